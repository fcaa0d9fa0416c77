// SPDX-License-Identifier: Apache-2.0
#include "learn/validate/cell_response.hpp"

#include "straight_cell.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(CellResponse) {
  CellParameters cell = StraightCell::cell();
  CellLog log = StraightCell::record(StraightCell::half());

  CellResponse response(OcvOf ocv = OcvOf::kSoc) {
    RunOptions options;
    options.capacity_ah = cell.capacity_ah;
    return respond(CellModel(cell, ocv), make_run(log, options), RecordedTemperature(log, 25.0, true));
  }
};

TEST(CellResponse, VoltageIsOcvLessTheDropOverR0) {
  const CellResponse r = response();
  for (const std::size_t row : {0U, 120U, 500U, 1019U})
    DOUBLES_EQUAL(log.voltage_v[row], r.voltage(static_cast<Eigen::Index>(row)), 1e-4);
}

TEST(CellResponse, CellWarmsByItsHeatAndCoolsToTheAir) {
  // 4 W into 500 J/K against 0.5 W/K: T = 25 + 8 K (1 - exp(-t / 1000 s)).
  const CellResponse r = response();
  DOUBLES_EQUAL(25.0 + 8.0 * (1.0 - std::exp(-0.9)), r.temperature(r.temperature.size() - 1), 0.01);
  DOUBLES_EQUAL(4.0, r.heat_w(500), 1e-3);
}

TEST(CellResponse, WithoutCoolingTheHeatAddsUp) {
  cell.convection_w_per_m2_k = 0.0;
  const CellResponse r = response();
  DOUBLES_EQUAL(25.0 + 900.0 * 4.0 / 500.0, r.temperature(r.temperature.size() - 1), 0.01);
}

TEST(CellResponse, ARecordedTemperatureIsTheTablesHoweverTheSurfaceLags) {
  log.temperature_c.assign(log.rows(), 25.0);
  for (std::size_t row = 0; row < log.rows(); ++row) log.temperature_c[row] += 0.01 * static_cast<double>(row);
  cell.effects.activation_energy_j_per_mol = 30e3;
  cell.surface_lag_s = 0.0;
  const Eigen::VectorXd at_once = response().voltage;
  cell.surface_lag_s = 60.0;
  DOUBLES_EQUAL(0.0, (response().voltage - at_once).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(CellResponse, RecordedAmbientIsTheAirOfTheModel) {
  log.ambient_c.assign(log.rows(), 15.0);
  cell.r0_ohm.value = {1e-7, 1e-7};  // no heat: an exponential to 15 degC
  const CellResponse r = response();
  DOUBLES_EQUAL(15.0 + 10.0 * std::exp(-1019.0 / 1000.0), r.temperature(r.temperature.size() - 1), 0.01);
}

TEST(CellResponse, OcvOfEachTestIsAddedToTheCurveOnlyWhenAsked) {
  // 20 mV more at 40 A than at 0 A, at every SOC and temperature.
  for (const double soc : cell.soc_breakpoints) {
    for (std::size_t t = 0; t < 3; ++t) {
      for (const double i : cell.current_breakpoints_a) cell.ocv_table_v.push_back(3.0 + soc + 0.02 * i / 40.0);
    }
  }
  const CellResponse curve = response(), table = response(OcvOf::kSocTemperatureCurrent);
  DOUBLES_EQUAL(0.010, table.voltage(500) - curve.voltage(500), 1e-9);
}

TEST(CellResponse, ExtendedCellAddsItsBranchItsHysteresisAndTheirHeat) {
  const CellResponse plain = response();
  cell.effects.slow_relaxation_ohm = 2e-3;
  cell.effects.slow_relaxation_tau_s = 300.0;
  cell.effects.hysteresis_v = 0.015;
  cell.effects.hysteresis_per_soc = 20.0;
  const CellResponse extended = response();
  // 880 s of 20 A, a twentieth of the capacity turns the hysteresis: 2 mOhm x 20 A (1 - exp(-t/tau)) + 15 mV.
  const Eigen::Index row = 1000;
  const double seconds = 1000.0 - StraightCell::kRest + 1.0, drawn = 20.0 * seconds / 36000.0;
  const double drop = 0.040 * (1.0 - std::exp(-seconds / 300.0)) + 0.015 * (1.0 - std::exp(-20.0 * drawn));
  DOUBLES_EQUAL(drop, plain.voltage(row) - extended.voltage(row), 1e-4);
  DOUBLES_EQUAL(20.0 * drop, extended.heat_w(row) - plain.heat_w(row), 0.01);
}

TEST(CellResponse, EntropyMovesTheOcvAndTakesHeat) {
  const CellResponse plain = response();
  cell.effects.entropy_v_per_k = 3e-4;
  const CellResponse warm = response();
  const Eigen::Index row = 500;
  DOUBLES_EQUAL(-20.0 * (warm.temperature(row) + 273.15) * 3e-4, warm.heat_w(row) - plain.heat_w(row), 0.02);
  DOUBLES_EQUAL(3e-4 * (warm.temperature(row) - 25.0), warm.voltage(row) - plain.voltage(row), 1e-5);
}

TEST(CellResponse, LookupsFollowTheSimulatedTemperatureWhereNoneWasRecorded) {
  // 10 mOhm less 1 % a kelvin; 4 W at first, 25 degC.
  cell.r0_ohm.per_kelvin = -0.01;
  const CellResponse r = response();
  const Eigen::Index row = 1000;
  CHECK(r.temperature(row) > 28.0);
  const double soc = log.voltage_v[static_cast<std::size_t>(row)] - 3.0 + 0.2;
  DOUBLES_EQUAL(3.0 + soc - 20.0 * 0.010 * (1.0 - 0.01 * (r.temperature(row) - 25.0)), r.voltage(row), 1e-4);
}

TEST(CellResponse, RecordingWithoutACellTemperatureStartsAtItsAmbientUnlessTold) {
  log.ambient_c.assign(log.rows(), 5.0);
  DOUBLES_EQUAL(5.0, RecordedTemperature(log, 25.0).start_c, 0.0);
  STRCMP_EQUAL("its ambient", RecordedTemperature(log, 25.0).start_from.c_str());
  DOUBLES_EQUAL(30.0, RecordedTemperature(log, 30.0, true).start_c, 0.0);
  STRCMP_EQUAL("--temperature", RecordedTemperature(log, 30.0, true).start_from.c_str());
  log.ambient_c.clear();
  STRCMP_EQUAL("assumed", RecordedTemperature(log, 25.0).start_from.c_str());
  log.temperature_c.assign(log.rows(), 12.0);
  STRCMP_EQUAL("recorded", RecordedTemperature(log, 30.0, true).start_from.c_str());
  DOUBLES_EQUAL(12.0, RecordedTemperature(log, 30.0, true).start_c, 0.0);
}

TEST(CellResponse, ReversibleHeatIsKeptApart) {
  cell.effects.entropy_v_per_k = 3e-4;
  const CellResponse r = response();
  DOUBLES_EQUAL(4.0, r.heat_w(500) - r.reversible_w(500), 1e-3);
  DOUBLES_EQUAL(-20.0 * (r.temperature(500) + 273.15) * 3e-4, r.reversible_w(500), 0.01);
}
