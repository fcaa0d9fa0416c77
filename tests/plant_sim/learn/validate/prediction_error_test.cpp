// SPDX-License-Identifier: Apache-2.0
#include "learn/validate/prediction_error.hpp"

#include <cmath>
#include <random>

#include "plant_sim/core/scratch.hpp"
#include "plant_sim/learn/identify/known_cell.hpp"
#include "core/parameter_file.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(Validation) {
  KnownCell truth;
  CellParameters cell;

  /// The known cell as a fine table.
  void setup() override {
    cell = load_cell(DataFolder(VOLTLAP_DATA_FOLDER), "aesc_e5_2p", "test");
    cell.name = "truth";
    cell.capacity_ah = truth.capacity_ah;
    cell.voltage_max_v = KnownCell::em(1.0);
    cell.temperature_breakpoints_c = {25.0};
    cell.current_breakpoints_a = {0.0};
    cell.soc_breakpoints.clear();
    cell.ocv_polynomial_v.clear();
    cell.r0_ohm = {};
    cell.branches = {};
    for (int k = 0; k <= 100; ++k) {
      const double s = k / 100.0;
      cell.soc_breakpoints.push_back(s);
      cell.ocv_soc.push_back(s);
      cell.ocv_v.push_back(KnownCell::em(s));
      cell.r0_ohm.value.push_back(KnownCell::r0(s));
      cell.branches[0].r_ohm.value.push_back(KnownCell::r1(s));
      cell.branches[1].r_ohm.value.push_back(KnownCell::r2(s));
      cell.branches[0].tau_s.value.push_back(KnownCell::tau1(s));
      cell.branches[1].tau_s.value.push_back(KnownCell::tau2(s));
    }
  }
};

TEST(Validation, TrueCellLeavesNoError) {
  const FileValidation v = validate(cell, truth.record(truth.pulse_plan(33.0, 600)), {});
  CHECK(v.rms_v < 3e-4);
  CHECK(v.rms_v_above_10_soc <= v.rms_v + 1e-4);
  STRCMP_EQUAL("full charge", v.soc_start_from.c_str());
  DOUBLES_EQUAL(0.98 * truth.capacity_ah, v.ah, 0.05);
  CHECK(!v.temperature_rms_c.has_value());
  DOUBLES_EQUAL(0.0, v.voltage_lag_s, 0.0);
}

TEST(Validation, ErrorIsThatOfTheModelLessTheRecordingInDischargeStrokesOnly) {
  CellLog log = truth.record(truth.pulse_plan(33.0, 600));
  for (std::size_t row = 0; row < log.rows(); ++row) log.voltage_v[row] -= log.current_a[row] > 0.0 ? 0.01 : 0.0;
  const FileValidation v = validate(cell, log, {});
  DOUBLES_EQUAL(0.01, v.bias_v, 3e-4);
  DOUBLES_EQUAL(0.01, v.rms_v, 3e-4);
  DOUBLES_EQUAL(0.01, v.max_error_v, 3e-3);
}

TEST(Validation, RecordingThatBeginsHalfEmptyIsPlacedByItsRest) {
  std::vector<double> plan(600, 0.0);
  plan.insert(plan.end(), 1200, 30.0);
  const FileValidation v = validate(cell, truth.record(plan, 0.6), {});
  STRCMP_EQUAL("rest", v.soc_start_from.c_str());
  DOUBLES_EQUAL(0.6, v.soc_start, 2e-3);
  CHECK(v.rms_v < 1e-3);
}

TEST(Validation, RecordingWithoutARestIsPlacedByItsVoltage) {
  std::vector<double> plan;
  for (int k = 0; k < 1500; ++k) plan.push_back(20.0 + 15.0 * std::sin(0.05 * k));
  const FileValidation v = validate(cell, truth.record(plan, 0.7), {});
  STRCMP_EQUAL("fitted", v.soc_start_from.c_str());
  DOUBLES_EQUAL(0.7, v.soc_start, 5e-3);
}

TEST(Validation, VoltageThatTrailsItsCurrentIsNamedADefect) {
  truth.row_s = 0.1;
  std::vector<double> plan(600, 0.0);
  for (int k = 0; k < 3000; ++k) plan.push_back(k % 5 < 2 ? 90.0 : 5.0);
  const CellLog log = truth.record(plan);
  double shown = log.voltage_v[0];
  CellLog trailing = log;
  for (std::size_t row = 1; row < log.rows(); ++row) {
    shown = log.voltage_v[row] + (shown - log.voltage_v[row]) * std::exp(-0.1 / 0.1);
    trailing.voltage_v[row] = shown;
  }
  const FileValidation v = validate(cell, trailing, {});
  DOUBLES_EQUAL(0.1, v.voltage_lag_s, 0.03);
  CHECK(v.rms_v_with_lag < 0.5 * v.rms_v);
}

TEST(Validation, OfASlowRecorderNoLagIsNamedThatIsShorterThanItsRows) {
  // A fast branch that the cell file lacks, in rows of two seconds: half of what R0 drops comes a second late.
  truth.row_s = 2.0;
  std::vector<double> plan(60, 0.0);
  for (int k = 0; k < 1500; ++k) plan.push_back(k % 5 < 2 ? 60.0 : 5.0);
  CellLog log = truth.record(plan);
  const double ohm = 2e-3;
  double late = 0.0;
  for (std::size_t row = 1; row < log.rows(); ++row) {
    late = log.current_a[row] + (late - log.current_a[row]) * std::exp(-2.0 / 1.0);
    log.voltage_v[row] += ohm * (log.current_a[row] - late);
  }
  DOUBLES_EQUAL(0.0, validate(cell, log, {}).voltage_lag_s, 0.0);
}

TEST(Validation, RecordingWithoutDischargeIsRefused) {
  std::vector<double> plan(600, 0.0);
  plan.insert(plan.end(), 1200, -30.0);
  plan.insert(plan.end(), 600, 0.0);
  const CellLog log = truth.record(plan, 0.3);
  STRCMP_CONTAINS("no discharge stroke", complaint([&] { (void)validate(cell, log, {}); }).c_str());
}

TEST(Validation, CapacityIsFoundFromADischarge) {
  cell.capacity_ah = 0.97 * truth.capacity_ah;
  const FileValidation v = validate(cell, truth.record(truth.pulse_plan(33.0, 600)), {});
  DOUBLES_EQUAL(0.03 * truth.capacity_ah, v.capacity.by_ah, 0.003 * truth.capacity_ah);
  CHECK(v.capacity.rms_v < 0.2 * v.rms_v);
  CHECK(!v.capacity.at_end);
}

TEST(Validation, TrueCapacityNeedsNoAdjustment) {
  const FileValidation v = validate(cell, truth.record(truth.pulse_plan(33.0, 600)), {});
  DOUBLES_EQUAL(0.0, v.capacity.by_ah, 0.002 * truth.capacity_ah);
  CHECK(v.capacity.rms_v <= v.rms_v);
}

TEST(Validation, CapacityFarOffIsSaidToBeOutOfReach) {
  cell.capacity_ah = 0.7 * truth.capacity_ah;
  CHECK(validate(cell, truth.record(truth.pulse_plan(33.0, 600)), {}).capacity.at_end);
}

TEST(Validation, OneCurrentOrSeveralAndTemperatureHeldOrFree) {
  CellLog log = truth.record(truth.pulse_plan(33.0, 600));
  CHECK(validate(cell, log, {}).constant_current);
  CHECK(validate(cell, log, {}).temperature == TemperatureKind::kNotRecorded);
  log.temperature_c.assign(log.rows(), 25.0);
  CHECK(validate(cell, log, {}).temperature == TemperatureKind::kHeld);
  log.temperature_c[log.rows() - 650] = 29.5;  // inside the last pulse
  for (std::size_t row = 0; row < log.rows(); ++row) log.temperature_c[row] += 1e-4 * static_cast<double>(row);
  CHECK(validate(cell, log, {}).temperature == TemperatureKind::kFree);
  std::vector<double> plan(600, 0.0);
  for (int k = 0; k < 3000; ++k) plan.push_back(k % 5 < 2 ? 60.0 : 5.0);
  CHECK(!validate(cell, truth.record(plan), {}).constant_current);
}

TEST(Validation, BandsOfSocShareOutTheWholeError) {
  CellLog log = truth.record(truth.pulse_plan(33.0, 600));
  for (std::size_t row = 0; row < log.rows(); ++row) log.voltage_v[row] += 1e-7 * static_cast<double>(row);
  const FileValidation v = validate(cell, log, {});
  ErrorSum sum;
  for (const SocBand& band : v.bands) sum += band.error;
  DOUBLES_EQUAL(v.rms_v, sum.rms_v(), 1e-12);
}

TEST(Validation, NoiseOfTheCurrentIsNoStroke) {
  // One discharge, then four hours of rest in which the sensor shows more than a hundredth of it now and then.
  std::vector<double> plan(120, 0.0);
  plan.insert(plan.end(), 1200, 60.0);
  plan.insert(plan.end(), 4 * 3600, 0.0);
  CellLog log = truth.record(plan);
  const double alone_v = validate(cell, log, {}).rms_v;
  std::mt19937 generator(3);
  std::normal_distribution<double> noise(0.0, 0.25);
  for (double& i : log.current_a) i += noise(generator);
  FileValidation v = validate(cell, log, {});
  LONGS_EQUAL(1, v.strokes);
  DOUBLES_EQUAL(alone_v, v.rms_v, 1e-3);
  log = truth.record(plan);
  for (std::size_t row = 2000; row < log.rows(); row += 200) log.current_a[row] = 0.9;
  v = validate(cell, log, {});
  LONGS_EQUAL(1, v.strokes);
}
