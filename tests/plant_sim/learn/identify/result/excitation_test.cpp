// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/result/excitation.hpp"

#include <limits>

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(Excitation) {
  IdentifyResult result;
  void setup() override {
    CircuitModel& model = result.model;
    model.grid = breakpoint_grid();
    model.em = Eigen::VectorXd::Constant(model.ocv.size(), 3.7);
    model.r = Eigen::MatrixXd::Constant(model.grid.size(), 3, 1e-3);
    model.tau = Eigen::MatrixXd::Constant(model.grid.size(), 2, 20.0);
    RecordingResult file;
    file.soc_low = 0.4;
    file.soc_high = 1.0;
    result.files.push_back(file);
    set_half_width(0.03);
  }
  void set_half_width(double relative) {
    const Eigen::Index all = result.model.em.size() + result.model.r.size() + result.model.tau.size();
    result.uncertainty.sigma = Eigen::VectorXd::Constant(all, relative / 1.96);
  }
};

TEST(Excitation, AResistanceThatIsKnownToThreePerCentIsSettled) {
  for (Eigen::Index table = 0; table < 5; ++table) CHECK(is_excited(result, table, result.model.grid.size() - 2));
}

TEST(Excitation, NeitherAWideIntervalNorANodeThatNoRecordingPassesIsSettled) {
  const Eigen::Index passed = result.model.grid.size() - 2;
  CHECK_FALSE(is_excited(result, 0, 1));
  set_half_width(0.25);
  CHECK_FALSE(is_excited(result, 0, passed));
  set_half_width(std::numeric_limits<double>::quiet_NaN());
  CHECK_FALSE(is_excited(result, 0, passed));
}

TEST(Excitation, AnOcvIsSettledWithinTenMillivolts) {
  const Eigen::Index passed = result.model.ocv.size() - 2;
  set_half_width(0.009);
  CHECK(is_ocv_excited(result, passed));
  CHECK_FALSE(is_ocv_excited(result, 0));
  set_half_width(0.011);
  CHECK_FALSE(is_ocv_excited(result, passed));
}
