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
