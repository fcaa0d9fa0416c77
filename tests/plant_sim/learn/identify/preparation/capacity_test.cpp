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
