// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/result/recording_error.hpp"

#include <cmath>

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(RecordingErrors) {
  RecordingResult file;
  void setup() override {
    file.trace.error_v = Eigen::VectorXd::Constant(1000, 0.002);
    file.trace.weight_s = Eigen::VectorXd::Constant(1000, 1.0);
    file.used.assign(1000, true);
  }
};

TEST(RecordingErrors, RowsThatTheFitLeftOutCountOnlyInTheErrorOfAllRows) {
  file.trace.error_v(999) = 3.7;
  file.used[999] = false;
  const RecordingError error = error_of(file);
  DOUBLES_EQUAL(0.002, error.rms_v, 1e-12);
  DOUBLES_EQUAL(0.002, error.largest_v, 1e-12);
  DOUBLES_EQUAL(0.117, error.all_rms_v, 1e-3);
}

TEST(RecordingErrors, AThousandthOfTheTimeLiesBeyondTheMost) {
  DOUBLES_EQUAL(0.002, error_of(file).most_v, 0.0);
  file.trace.error_v(4) = 0.5;  // one of a thousand
  DOUBLES_EQUAL(0.5, error_of(file).largest_v, 0.0);
  DOUBLES_EQUAL(0.002, error_of(file).most_v, 0.0);
  file.trace.error_v(7) = -0.3;
  DOUBLES_EQUAL(0.3, error_of(file).most_v, 0.0);
  DOUBLES_EQUAL(0.0, most_of({}), 0.0);
}

TEST(RecordingErrors, RecordingsTogetherAreWeightedByTheirTime) {
  CellIdentification identified;
  identified.points.resize(1);
  identified.points[0].result.files = {file, file};
  identified.points[0].result.files[1].trace.error_v.setConstant(0.004);
  identified.points[0].result.files[1].trace.weight_s.setConstant(3.0);
  DOUBLES_EQUAL(std::sqrt((4.0 + 3.0 * 16.0) / 4.0) * 1e-3, error_of(identified).rms_v, 1e-12);
}
