// SPDX-License-Identifier: Apache-2.0
#include "learn/validate/error_sensitivity.hpp"

#include "straight_cell.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(ErrorSensitivity) {
  CellParameters cell = StraightCell::cell();
  CellLog log = StraightCell::record(StraightCell::half());
  std::vector<ErrorSensitivity> rows;

  void setup() override {
    std::vector<PlacedRecording> recordings;
    recordings.push_back(place_recording(CellModel(cell), log, {}));
    rows = error_sensitivities(cell, recordings, {{}});
  }
  double rms_mv(const std::string& parameter, std::size_t step) const {
    for (const ErrorSensitivity& row : rows) {
      if (row.parameter == parameter) return 1e3 * row.rms_v[step];
    }
    return -1.0;
  }
};

TEST(ErrorSensitivity, NominalModelOfItsOwnRecordingHasNoError) {
  DOUBLES_EQUAL(0.0, rms_mv("em", 2), 0.02);
}

TEST(ErrorSensitivity, EmIsWrongByItsOwnShare) {
  // Mean of (3 + s)^2 over s from 0.5 to 1: (4^3 - 3.5^3) / 3 / 0.5.
  const double rms = std::sqrt((64.0 - 42.875) / 1.5);
  DOUBLES_EQUAL(50.0 * rms, rms_mv("em", 0), 0.1);
  DOUBLES_EQUAL(10.0 * rms, rms_mv("em", 3), 0.1);
}

TEST(ErrorSensitivity, R0IsWrongByItsShareOfTheDrop) {
  DOUBLES_EQUAL(0.05 * 200.0, rms_mv("r0", 0), 0.03);
  DOUBLES_EQUAL(0.01 * 200.0, rms_mv("r0", 1), 0.03);
  DOUBLES_EQUAL(0.05 * 200.0, rms_mv("r0", 4), 0.03);
}

TEST(ErrorSensitivity, InitialSocShiftsTheCurve) {
  DOUBLES_EQUAL(50.0, rms_mv("initial_soc", 0), 0.05);
  DOUBLES_EQUAL(10.0, rms_mv("initial_soc", 3), 0.05);
}

TEST(ErrorSensitivity, CapacityGrowsAlongTheDischarge) {
  // Drawn share of SOC runs from 0 to 0.5; its error is (1 - 1/1.05) of it: rms = 0.5 / sqrt(3) of that.
  DOUBLES_EQUAL(1e3 * (1.0 - 1.0 / 1.05) * 0.5 / std::sqrt(3.0), rms_mv("capacity", 0), 0.05);
  DOUBLES_EQUAL(1e3 * (1.0 / 0.99 - 1.0) * 0.5 / std::sqrt(3.0), rms_mv("capacity", 3), 0.05);
}

TEST(ErrorSensitivity, BranchesTooSmallToSeeDoNotMatter) {
  for (const char* parameter : {"r1", "r2", "c1", "c2"}) DOUBLES_EQUAL(rms_mv("em", 2), rms_mv(parameter, 0), 1e-3);
}
