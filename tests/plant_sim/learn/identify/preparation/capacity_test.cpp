// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/preparation/capacity.hpp"

#include <algorithm>
#include <cmath>

#include "learn/identify/preparation/prepared_log.hpp"
#include "plant_sim/learn/identify/known_cell.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

namespace {

std::vector<OcvKnowledge> known_ocv(double sigma_v) {
  std::vector<OcvKnowledge> out;
  for (int k = 0; k <= 40; ++k) out.push_back({k / 40.0, KnownCell::em(k / 40.0), sigma_v});
  return out;
}

/// A drive of this charge, with rests of this length at both ends.
std::vector<double> drive(double ah, int rest_s) {
  std::vector<double> plan(static_cast<std::size_t>(rest_s), 0.0);
  const auto seconds = static_cast<int>(std::lround(3600.0 * ah / 45.0));
  for (int k = 0; k < seconds; ++k) plan.push_back(k / 20 % 2 == 0 ? 75.0 : 15.0);
  plan.insert(plan.end(), static_cast<std::size_t>(rest_s), 0.0);
  return plan;
}

bool has(const std::vector<std::string>& lines, const char* words) {
  return std::any_of(lines.begin(), lines.end(),
                     [&](const std::string& line) { return line.find(words) != std::string::npos; });
}

}  // namespace

TEST_GROUP(Capacity) {
  KnownCell cell;
  PriorKnowledge known;
  std::vector<std::string> notes;
  std::vector<CellLog> logs;
  PreparedLog prepared(CellLog log) {
    logs = {std::move(log)};
    return prepare(logs, known, notes).front();
  }
};

TEST(Capacity, WholeDischargeIsTheCapacity) {
  const PreparedLog one = prepared(cell.record(cell.pulse_plan(33.0, 600)));
  CHECK(one.capacity.from == CapacityFrom::kWholeDischarge);
  DOUBLES_EQUAL(0.98 * cell.capacity_ah, one.capacity.ah, 0.05);
  CHECK(has(notes, "what the longest discharge draws"));
}

TEST(Capacity, EndsThatAreNoneAreToldByTheirVoltages) {
  // An NMC cell rests at 3.45 V with a tenth of its charge, one of iron phosphate at 3.33 V half full.
  struct Rests {
    double begin_v, end_v;
    bool full, empty;
  };
  for (const Rests& rests : {Rests{4.18, 3.45, true, false}, {4.18, 3.1, true, true}, {3.98, 3.1, false, true},
                             {3.33, 2.5, false, true}, {3.36, 3.2, true, false}}) {
    CellLog log;
    for (int row = 0; row < 4000; ++row) {
      log.time_s.push_back(row);
      log.current_a.push_back(row < 200 || row >= 3800 || row / 100 % 2 == 0 ? 0.0 : 2.0);
      log.voltage_v.push_back(rests.begin_v + (rests.end_v - rests.begin_v) * row / 3999.0);
      log.temperature_c.push_back(25.0);
    }
    log.gap.assign(log.rows(), false);
    RunOptions run;
    run.capacity_ah = 1.0;
    const RecordedEnds ends = recorded_ends(log, run);
    const SimpleString what = StringFromFormat("%.2f to %.2f V", rests.begin_v, rests.end_v);
    CHECK_EQUAL_TEXT(rests.full, ends.full, what.asCharString());
    CHECK_EQUAL_TEXT(rests.empty, ends.empty, what.asCharString());
  }
}

TEST(Capacity, WhatADriveDrewIsCalledSo) {
  for (const double start_soc : {1.0, 0.75}) {
    notes.clear();
    const PreparedLog one = prepared(cell.record(drive(9.0, 120), start_soc));
    CHECK(one.capacity.from == CapacityFrom::kDrawnOnly);
    DOUBLES_EQUAL(9.0, one.capacity.ah, 0.1);
    CHECK(has(notes, "only what the recordings drew") && has(notes, "--capacity AH"));
    CHECK_EQUAL(start_soc < 1.0, has(notes, "SOC 1 is assumed"));
    CHECK_EQUAL(start_soc < 1.0, one.run.anchor.from == "assumed");
  }
}

TEST(Capacity, WhatIsToldIsUsed) {
  known.capacity_ah = 31.0;
  const PreparedLog one = prepared(cell.record(drive(9.0, 120)));
  CHECK(one.capacity.from == CapacityFrom::kTold);
  DOUBLES_EQUAL(31.0, one.run.capacity_ah, 0.0);
  CHECK(has(notes, "span 9.0"));
}

TEST(Capacity, RestsAtBothEndsAndAnOcvTellItWithAnIntervalThatHoldsTheTruth) {
  known.ocv = known_ocv(2e-3);
  cell.noise_v = 5e-4;
  for (const double start_soc : {0.95, 0.85, 0.7}) {
    const PreparedLog one = prepared(cell.record(drive(12.0, 1800), start_soc));
    CHECK(one.capacity.from == CapacityFrom::kRestsAndOcv);
    CHECK(one.capacity.ci95_ah.has_value());
    DOUBLES_EQUAL(cell.capacity_ah, one.capacity.ah, *one.capacity.ci95_ah);
    CHECK(*one.capacity.ci95_ah < 0.15 * cell.capacity_ah);
    // The SOC is the OCV's, not 1 where the recording begins.
    DOUBLES_EQUAL(start_soc, one.run.anchor.soc, 0.03);
  }
}

TEST(Capacity, AFullChargeCannotStandWhereTwoAmpereHoursWereDrawn) {
  // Regeneration for three minutes at the end, with the highest voltage of all.
  std::vector<double> plan = drive(2.0, 30);
  plan.insert(plan.end(), 180, -2.0);
  CellLog log = cell.record(plan, 0.8);
  for (std::size_t row = log.rows() - 180; row < log.rows(); ++row) log.voltage_v[row] += 0.1;
  log.current_a.back() = 0.0;
  CHECK(!full_charges(log).empty());
  const PreparedLog one = prepared(log);
  DOUBLES_EQUAL(2.0, one.capacity.ah, 0.02);
  CHECK(one.capacity.from == CapacityFrom::kDrawnOnly);
  known.capacity_ah = 30.0;
  notes.clear();
  (void)prepared(log);
  CHECK(has(notes, "span 2.0") || has(notes, "span 1.9"));
}
