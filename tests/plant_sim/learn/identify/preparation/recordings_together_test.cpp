// SPDX-License-Identifier: Apache-2.0
// Recordings of one cell that do not quite agree: a capacity of their own, or none that any model shares.
#include <algorithm>

#include "learn/identify/identify.hpp"
#include "learn/identify/preparation/contradictions.hpp"
#include "learn/identify/preparation/recording_soc.hpp"
#include "plant_sim/learn/identify/laws_cell.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(RecordingsTogether) {
  LawsCell cell;
  IdentifyOptions options;
  void setup() override { options.branches = 2; }
  static bool says(const IdentifyResult& result, const char* what) {
    return std::any_of(result.notes.begin(), result.notes.end(),
                       [&](const std::string& note) { return note.find(what) != std::string::npos; });
  }
  CellLog named(const char* name, CellLog log) const {
    log.path = name;
    return log;
  }
};

TEST(RecordingsTogether, OneThatContradictsIsLeftOutAndNamed) {
  const auto plan = cell.pulses({1.0, 2.0});
  CellLog behind_a_cable = named("cable.csv", cell.record(cell.pulses({0.3}), 25.0));
  for (std::size_t row = 0; row < behind_a_cable.rows(); ++row)
    behind_a_cable.voltage_v[row] -= 0.15 * behind_a_cable.current_a[row];
  const CellLog first = named("a.csv", cell.record(plan, 25.0)), second = named("b.csv", cell.record(plan, 15.0));
  const IdentifyResult without = identify({first, second}, options),
                       with = identify({first, behind_a_cable, second}, options);
  CHECK(says(with, "cable.csv contradicts"));
  CHECK(!says(without, "contradicts"));
  LONGS_EQUAL(2, with.files.size());
  DOUBLES_EQUAL(1.0, with.model.r0_ohm(8, 5.0) / without.model.r0_ohm(8, 5.0), 0.01);
}

TEST(RecordingsTogether, OneThatIsLeftOutTellsNoCapacity) {
  std::vector<double> short_plan = cell.pulses({0.3});
  short_plan.resize(short_plan.size() / 2);
  CellLog behind_a_cable = named("cable.csv", cell.record(short_plan, 25.0));
  for (std::size_t row = 0; row < behind_a_cable.rows(); ++row)
    behind_a_cable.voltage_v[row] -= 0.15 * behind_a_cable.current_a[row];
  const CellLog first = named("a.csv", cell.record(cell.pulses({1.0, 2.0}), 25.0)),
                second = named("b.csv", cell.record(cell.pulses({1.0, 2.0}), 15.0));
  options.temperatures_c = {25.0, 25.0, 15.0};
  const IdentifyResult with = identify({behind_a_cable, first, second}, options);
  options.temperatures_c = {25.0, 15.0};
  const IdentifyResult without = identify({first, second}, options);
  CHECK(says(with, "cable.csv contradicts"));
  DOUBLES_EQUAL(without.model.capacity_ah, with.model.capacity_ah, 1e-9);
  DOUBLES_EQUAL(without.rms_v, with.rms_v, 1e-9);
  STRCMP_EQUAL("a.csv", with.files.front().path.c_str());
}

TEST(RecordingsTogether, WhereAnotherBeginsIsFoundWithTheTables) {
  const auto plan = cell.pulses({1.0, 2.0});
  std::vector<double> part = cell.pulses({1.5});
  part.resize(part.size() / 2);
  for (const double start : {0.62, 0.83, 0.95}) {
    CellLog unknown = named("part.csv", cell.record(part, 25.0, start));
    const IdentifyResult r = identify({named("whole.csv", cell.record(plan, 25.0)), unknown}, options);
    // SOC 0 is where the whole one ends: at a tenth of the cell's.
    const double first = r.files[1].trace.soc(0), truth = 1.0 - (1.0 - start) * cell.capacity_ah / r.model.capacity_ah;
    DOUBLES_EQUAL(truth, first, 0.004);
    CHECK(r.rms_v < 2e-3);
  }
}

TEST(RecordingsTogether, OfACellThatAgedIsCountedWithItsOwnCapacity) {
  LawsCell aged = cell;
  aged.capacity_ah = 0.93 * cell.capacity_ah;
  const auto plan = cell.pulses({1.0, 2.0});
  std::vector<double> aged_plan = aged.pulses({1.0});
  const IdentifyResult result =
      identify({named("new.csv", cell.record(plan, 25.0)), named("new2.csv", cell.record(cell.pulses({1.5}), 25.0)),
                named("aged.csv", aged.record(aged_plan, 25.0))}, options);
  CHECK(says(result, "aged.csv agrees with the other recordings at a capacity of"));
  CHECK(!says(result, "contradicts"));
  // SOC 0 is where the pulses end: 0.9 of the true capacity.
  DOUBLES_EQUAL(1.0, result.model.capacity_ah / (0.9 * cell.capacity_ah), 0.01);
  CHECK(result.rms_v < 2e-3);
}

TEST(RecordingsTogether, OneThatACircuitFollowsWorseIsLeftOutByNothing) {
  // A third of the resistance lags by half an hour: no two branches follow pulses and a discharge alike.
  const auto lagging = [&](std::vector<double> plan) {
    CellLog log = cell.record(plan, 25.0);
    double v = 0.0;
    for (std::size_t row = 0; row < log.rows(); ++row) {
      v += (0.7 * cell.r0_ohm * plan[row] - v) / 1800.0;
      log.voltage_v[row] -= v;
    }
    return log;
  };
  std::vector<double> discharge(300, 0.0);
  discharge.insert(discharge.end(), static_cast<std::size_t>(0.9 * 3600.0 / 2.0), 2.0 * cell.capacity_ah);
  discharge.insert(discharge.end(), 600, 0.0);
  const IdentifyResult r = identify({named("pulses.csv", lagging(cell.pulses({1.0}))),
                                     named("discharge.csv", lagging(discharge))}, options);
  CHECK(!says(r, "contradicts"));
  LONGS_EQUAL(2, r.files.size());
}

TEST(RecordingsTogether, HysteresisOfASlowPairIsSeenBesideAColdTest) {
  cell.r1_kj = cell.r2_kj = cell.ohmic_kj = 45.0;  // ten times the resistance at -10 degC
  std::vector<double> pair(300, 0.0);
  const auto hours = static_cast<std::size_t>(18 * 3600);
  pair.insert(pair.end(), hours, 0.05 * cell.capacity_ah);
  pair.insert(pair.end(), hours, -0.05 * cell.capacity_ah);
  const auto with_state = [&](const std::vector<double>& plan, double at_c) {
    CellLog log = cell.record(plan, at_c);
    double state = -0.012;
    for (std::size_t row = 0; row < log.rows(); ++row) {
      const double turn = 60.0 * std::abs(plan[row]) / (3600.0 * cell.capacity_ah);
      if (plan[row] != 0.0) state += ((plan[row] > 0.0 ? 0.012 : -0.012) - state) * turn;
      log.voltage_v[row] -= state;
    }
    return log;
  };
  const IdentifyResult r = identify({named("warm.csv", with_state(cell.pulses({1.0}), 25.0)),
                                     named("cold.csv", with_state(cell.pulses({0.5}), -10.0)),
                                     named("pair.csv", with_state(pair, 25.0))}, options);
  DOUBLES_EQUAL(0.012, r.hysteresis_v, 0.2 * 0.012);
}

TEST(RecordingsTogether, WithoutAThermometerLawsAreLessSure) {
  options.temperatures_c = {25.0, 5.0};
  options.thermal = [&](double) { return CellThermal{cell.capacity_ah * 12.0, 0.05, 0.0}; };
  std::vector<CellLog> logs{named("a.csv", cell.record(cell.pulses({3.0}), 25.0)),
                            named("b.csv", cell.record(cell.pulses({3.0}), 5.0))};
  const auto sigma = [](const IdentifyResult& r) {
    return r.uncertainty.sigma(r.packed.size() - ResistanceLaws::kCount + ResistanceLaws::kOhmic);
  };
  const double recorded = sigma(identify(logs, options));
  for (CellLog& log : logs) log.temperature_c.clear();
  const IdentifyResult without = identify(logs, options);
  CHECK(without.files[0].warmest_c > 26.0);
  CHECK(sigma(without) > 1.5 * recorded);
}
