// SPDX-License-Identifier: Apache-2.0
// Bounds of causes that depend on the cell, as that there is no less than nothing of a hysteresis, and forms that
// depend on what was driven.
#include "explain/causes/list.hpp"

#include <optional>

#include <CppUTest/TestHarness.h>

#include "explain/balances/model.hpp"

using namespace voltlap::plant;

TEST_GROUP(Causes) {
  CellParameters cell = load_model(DataFolder(VOLTLAP_DATA_FOLDER), "aesc_e5_2p", {}).world.car.cell;

  double lowest(const std::string& name) const {
    std::vector<Cause> causes = catalogue({});
    size_for(cell, causes);
    for (const Cause& cause : causes) {
      if (name == cause.name) return cause.parameters[0].low;
    }
    FAIL("no such cause");
    return 0.0;
  }
};

TEST(Causes, ACellThatHasNoneCanHaveNoLessHysteresisOrSlowRelaxation) {
  DOUBLES_EQUAL(0.0, lowest("hysteresis"), 0.0);
  DOUBLES_EQUAL(0.0, lowest("slow_relaxation"), 0.0);
}

TEST(Causes, WhatAModelHasCanBeTakenAway) {
  cell.effects.hysteresis_v = 0.02;
  cell.effects.slow_relaxation_ohm = 3e-4;
  DOUBLES_EQUAL(-0.02, lowest("hysteresis"), 0.0);
  DOUBLES_EQUAL(-3e-4, lowest("slow_relaxation"), 0.0);
}

TEST(Causes, APriorIsLeftAtItsEndsButNotAtZero) {
  const CauseParameter both{"change", "1", -0.5, 0.5, 0.1}, more{"delay_s", "s", 0.0, 1.0, 0.1},
      less{"capacity_change", "1", -1.0, 0.0, 0.1};
  CHECK(is_inside_prior(both, 0.0) && is_inside_prior(both, 0.47) && is_inside_prior(both, -0.47));
  CHECK_FALSE(is_inside_prior(both, 0.49));
  CHECK_FALSE(is_inside_prior(both, -0.49));
  CHECK(is_inside_prior(more, 1e-6) && is_inside_prior(less, -1e-6));
  CHECK_FALSE(is_inside_prior(more, 0.0));
  CHECK_FALSE(is_inside_prior(more, 0.99));
  CHECK_FALSE(is_inside_prior(less, 0.0));
  CHECK_FALSE(is_inside_prior(less, -0.99));
}

TEST(Causes, APriorOfATimeConstantIsMeasuredInLogarithms) {
  const CauseParameter tau{"tau_s", "s", 100.0, 3000.0, 500.0};
  CHECK(is_inside_prior(tau, 110.0) && is_inside_prior(tau, 150.0) && is_inside_prior(tau, 2700.0));
  CHECK_FALSE(is_inside_prior(tau, 105.0));
  CHECK_FALSE(is_inside_prior(tau, 2900.0));
}

TEST_GROUP(OcvShape) {
  static constexpr Eigen::Index kRows = 3000;  // 10 Hz

  const World model = load_model(DataFolder(VOLTLAP_DATA_FOLDER), "aesc_e5_2p", {}).world;

  /// Of a log that begins full, at the voltage of no other charge, and draws this share of it; and whose SOC reads
  /// this.
  Comparison drawing(double share, std::optional<double> soc = {}) const {
    Recording log;
    log.time_s = Eigen::VectorXd::LinSpaced(kRows, 0.0, 0.1 * (kRows - 1));
    const double coulombs = 3600.0 * model.car.cell.capacity_ah * model.car.battery.cells_in_parallel;
    log.signals["current"] = Eigen::VectorXd::Constant(kRows, share * coulombs / log.time_s(kRows - 1));
    log.signals["current"].head(600).setZero();
    log.signals["voltage"] = Eigen::VectorXd::Constant(kRows, 4.15);
    if (soc) log.signals["soc"] = Eigen::VectorXd::Constant(kRows, *soc);
    return comparison_of(model, log, {});
  }

  std::vector<Form> forms(const Comparison& c) const {
    for (const Cause& cause : catalogue({})) {
      if (std::string(cause.name) == "ocv_shape") return cause.forms(model, c);
    }
    FAIL("no such cause");
    return {};
  }
};

TEST(OcvShape, AShallowDriveFromFullShowsALevelASlopeAndABend) {
  const Comparison c = drawing(0.06);
  const std::vector<Form> shallow = forms(c);
  LONGS_EQUAL(1, shallow.size());
  LONGS_EQUAL(3, shallow[0].linear.size());
  World bent = model;
  shallow[0].apply(bent, std::vector<double>{0.01, 0.0, 0.02, 0.0, 0.0, 0.0, 0.0});
  const Eigen::VectorXd soc = predict(model, c).battery.soc;
  const std::vector<double>& change = bent.car.cell.effects.ocv_change_v;
  const auto at = [&](double where) {
    return change[static_cast<std::size_t>(std::lround(where * static_cast<double>(change.size() - 1)))];
  };
  constexpr double kStep = 0.0025 * 0.02 / 0.04;  // V: half a stored step of SOC on the steeper side
  DOUBLES_EQUAL(0.01, at(0.0), 1e-12);
  DOUBLES_EQUAL(0.01, at(soc.minCoeff()), kStep);
  DOUBLES_EQUAL(0.0, at(0.5 * (soc.minCoeff() + soc.maxCoeff())), kStep);
  DOUBLES_EQUAL(0.02, at(1.0), kStep);
  // A second one adds to it.
  shallow[0].apply(bent, std::vector<double>{-0.01, 0.0, -0.02, 0.0, 0.0, 0.0, 0.0});
  for (const double left : bent.car.cell.effects.ocv_change_v) DOUBLES_EQUAL(0.0, left, 1e-12);
}

TEST(OcvShape, ASocThatIsNotJudgedStretchesNothing) {
  LONGS_EQUAL(3, forms(drawing(0.06, 0.1))[0].linear.size());
}

TEST(OcvShape, ADeepDriveShowsMoreOfItAndOneThatDrawsNothingNothing) {
  LONGS_EQUAL(7, forms(drawing(0.8))[0].linear.size());
  LONGS_EQUAL(0, forms(drawing(0.005)).size());
}
