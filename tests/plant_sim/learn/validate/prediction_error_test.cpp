// SPDX-License-Identifier: Apache-2.0
#include "learn/validate/prediction_error.hpp"

#include <cmath>
#include <cstdlib>
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

TEST(Validation, OnAPlateauNoRestIsFullThatAHysteresisLiftsThereAndAFullOneIs) {
  // An iron phosphate cell: 3.33 to 3.34 V from 0.3 to 0.96 of its charge, 3.40 V full; its curve is that of discharge,
  // a charge before leaves it 20 to 35 mV above.
  const auto em = [](double s) {
    return s < 0.3 ? 2.83 + s / 0.6 : s < 0.96 ? 3.33 + 0.01 * (s - 0.3) / 0.66 : 3.34 + 0.06 * (s - 0.96) / 0.04;
  };
  for (std::size_t k = 0; k < cell.ocv_soc.size(); ++k) cell.ocv_v[k] = em(cell.ocv_soc[k]);
  cell.voltage_max_v = 3.6;
  const char* given = std::getenv("VOLTLAP_TEST_SEED");
  std::mt19937 draw(given != nullptr ? static_cast<unsigned>(std::atoi(given)) : 1U);
  for (int trial = 0; trial < 20; ++trial) {
    const bool full = trial % 4 == 0;
    const double start = full ? 1.0 : std::uniform_real_distribution(0.45, 0.93)(draw);
    const double lifted_v = std::uniform_real_distribution(0.02, 0.035)(draw);
    CellLog log;
    log.path = "plateau";
    double s = start;
    for (int row = 0; row < 2000; ++row) {
      const double i = row < 300 ? 0.0 : 30.0;
      s -= i / 3600.0 / cell.capacity_ah;
      log.time_s.push_back(row);
      log.current_a.push_back(i);
      log.voltage_v.push_back(em(s) + lifted_v - 2e-3 * i);
      log.gap.push_back(false);
    }
    const FileValidation v = validate(cell, log, {});
    const auto said = StringFromFormat("VOLTLAP_TEST_SEED=%s, trial %d: SOC %.3f, lifted by %.1f mV: %.3f from %s",
                                       given != nullptr ? given : "1", trial, start, 1e3 * lifted_v, v.soc_start,
                                       v.soc_start_from.c_str());
    CHECK_TEXT((v.soc_start_from == "full charge") == full, said.asCharString());
  }
}

TEST(Validation, RestBelowTheCurveOfACellThatWasEmptiedUnderLoadTellsNoSoc) {
  std::vector<double> plan(60, 0.0);
  const double amps = 30.0, start = 0.8;
  plan.insert(plan.end(), static_cast<std::size_t>(start * 3600.0 * truth.capacity_ah / amps), amps);
  CellLog log = truth.record(plan, start);
  for (int row = 0; row < 900; ++row) {
    log.time_s.push_back(log.time_s.back() + 1.0);
    log.current_a.push_back(0.0);
    log.voltage_v.push_back(KnownCell::em(0.0) - 0.3);
    log.gap.push_back(false);
  }
  const FileValidation v = validate(cell, log, {});
  CHECK(v.soc_start_from != "rest");
  DOUBLES_EQUAL(start, v.soc_start, 0.02);
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
