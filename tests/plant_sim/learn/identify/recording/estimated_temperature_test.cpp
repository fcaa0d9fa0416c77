// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/recording/estimated_temperature.hpp"

#include <cmath>

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

namespace {

constexpr CellThermal kBody{500.0, 0.5, 0.0};  // J/K, W/K: a thousand seconds

/// `current_a` from the second row on, a row a second, at 4 V less 10 mOhm.
CellLog constant(double current_a, std::size_t rows) {
  CellLog log;
  for (std::size_t row = 0; row < rows; ++row) {
    log.time_s.push_back(static_cast<double>(row));
    log.current_a.push_back(row == 0 ? 0.0 : current_a);
    log.voltage_v.push_back(4.0 - 0.010 * log.current_a.back());
  }
  log.gap.assign(rows, false);
  return log;
}

/// 4 W of 20 A in 10 mOhm: 8 K at last.
double warmed(double start_c, double air_c, double seconds) {
  return air_c + 8.0 + (start_c - air_c - 8.0) * std::exp(-seconds / 1000.0);
}

}  // namespace

TEST_GROUP(EstimatedTemperature) {
  CellLog log = constant(20.0, 901);
  HeatEstimate heat;

  double last(CurrentHold hold = CurrentHold::kNext, const ThermalStart& start = {}) {
    return estimated_temperature(log, hold, kBody, heat, start).back();
  }
};

TEST(EstimatedTemperature, ResistanceWarmsTheCellAgainstItsCooling) {
  heat.resistance_ohm = 0.010;
  DOUBLES_EQUAL(warmed(25.0, 25.0, 900.0), last(), 1e-9);
  DOUBLES_EQUAL(warmed(25.0, 25.0, 899.0), last(CurrentHold::kPrevious), 1e-9);
  DOUBLES_EQUAL(warmed(30.0, 10.0, 900.0), last(CurrentHold::kNext, {30.0, 10.0}), 1e-9);
}

TEST(EstimatedTemperature, OpenCircuitVoltageTellsTheSameHeat) {
  heat.ocv_v.assign(log.rows(), 4.0);
  DOUBLES_EQUAL(warmed(25.0, 25.0, 900.0), last(), 1e-9);
  // Where it is unknown the resistance stands in.
  for (std::size_t row = 300; row < 600; ++row) heat.ocv_v[row] = std::nan("");
  heat.resistance_ohm = 0.010;
  DOUBLES_EQUAL(warmed(25.0, 25.0, 900.0), last(), 1e-9);
}

TEST(EstimatedTemperature, ARapidDischargeIsNotHeldAtItsStart) {
  // 3C of a 2.5 Ah cell with 30 mOhm, 45 g: 1.7 W into 41 J/K.
  log = constant(7.5, 1201);
  heat.resistance_ohm = 0.030;
  const double end_c = estimated_temperature(log, CurrentHold::kNext, {41.0, 0.04, 0.0}, heat, {}).back();
  const double settles = 7.5 * 7.5 * 0.030 / 0.04;
  DOUBLES_EQUAL(25.0 + settles * (1.0 - std::exp(-1200.0 * 0.04 / 41.0)), end_c, 1e-9);
  CHECK(end_c > 50.0);
}

TEST(EstimatedTemperature, ResistanceOfAColdCellFallsAsItWarms) {
  heat.resistance_ohm = 0.010;
  heat.activation_energy_j_per_mol = 20000.0;
  const double cold = last(CurrentHold::kNext, {-10.0, -10.0});
  const double factor = std::exp(20000.0 / 8.314462618 * (1.0 / 263.15 - 1.0 / 298.15));  // 2.9 at the start
  const double straight = -10.0 + 8.0 * factor * (1.0 - std::exp(-0.9));
  CHECK(cold > warmed(-10.0, -10.0, 900.0) + 3.0);
  CHECK(cold < straight - 0.5);
}

TEST(EstimatedTemperature, EntropyTakesOrGivesHeat) {
  heat.resistance_ohm = 0.010;
  heat.entropy_v_per_k = 4.0 / (20.0 * 298.15);  // as much as the resistance makes, at 25 degC
  DOUBLES_EQUAL(25.0, last(), 1e-6);
  log = constant(-20.0, 901);
  DOUBLES_EQUAL(25.0 + 16.0 * (1.0 - std::exp(-0.9)), last(), 0.2);  // a little more as it warms
}

TEST(EstimatedTemperature, ResistanceMakesNoCold) {
  heat.ocv_v.assign(log.rows(), 3.7);  // below the voltage under load
  DOUBLES_EQUAL(25.0, last(), 1e-12);
}

TEST(EstimatedTemperature, RecordedAmbientIsTheAirAndAGapOnlyCools) {
  heat.resistance_ohm = 0.010;
  log.ambient_c.assign(log.rows(), 15.0);
  DOUBLES_EQUAL(warmed(25.0, 15.0, 900.0), last(), 1e-9);
  log.gap.assign(log.rows(), true);
  DOUBLES_EQUAL(15.0 + 10.0 * std::exp(-0.9), last(), 1e-9);
}
