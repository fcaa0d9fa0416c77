// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/circuit/circuit_model.hpp"

#include <cmath>

#include "learn/identify/recording/measured_run.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(CircuitModel){};

TEST(CircuitModel, IntervalResponseIsExactForAHeldAndForAStraightCurrent) {
  const double dt = 7.0, tau = 3.0, r = 0.02, v0 = 0.05;
  const IntervalResponse w = interval_response(dt, tau);
  const double held = r * 10.0 + (v0 - r * 10.0) * std::exp(-dt / tau);
  DOUBLES_EQUAL(held, w.a * v0 + (w.g0 + w.g1) * r * 10.0, 1e-15);
  // dv/dt = (r (i0 + m t) - v)/tau has v = r (i0 + m (t - tau)) + c exp(-t/tau).
  const double i0 = 10.0, i1 = -4.0, m = (i1 - i0) / dt, c = v0 - r * (i0 - m * tau);
  const double straight = r * (i1 - m * tau) + c * std::exp(-dt / tau);
  DOUBLES_EQUAL(straight, w.a * v0 + w.g0 * r * i0 + w.g1 * r * i1, 1e-15);
}

TEST(CircuitModel, IntervalResponseHasTheDerivativesItSays) {
  for (const double dt : {0.1, 1.0, 60.0}) {
    const double tau = 12.0, h = 1e-4;
    const IntervalResponse w = interval_response(dt, tau), up = interval_response(dt, tau + h),
                           down = interval_response(dt, tau - h);
    DOUBLES_EQUAL((up.a - down.a) / (2 * h), w.da, 1e-9);
    DOUBLES_EQUAL((up.g0 - down.g0) / (2 * h), w.dg0, 1e-9);
    DOUBLES_EQUAL((up.g1 - down.g1) / (2 * h), w.dg1, 1e-9);
  }
}

TEST(CircuitModel, GridIsStraightBetweenNodesAndHeldBeyond) {
  const SocGrid grid({0.0, 0.5, 1.0});
  const Eigen::Vector3d y(1.0, 2.0, 4.0);
  DOUBLES_EQUAL(1.5, grid.value(y, 0.25), 1e-15);
  DOUBLES_EQUAL(3.0, grid.value(y, 0.75), 1e-15);
  DOUBLES_EQUAL(1.0, grid.value(y, -0.2), 1e-15);
  DOUBLES_EQUAL(4.0, grid.value(y, 1.3), 1e-15);
}

TEST(CircuitModel, RoughnessOfAStraightLineIsNothingAndOfAParabolaItsCurvature) {
  const SocGrid grid = breakpoint_grid();
  Eigen::VectorXd line(grid.size()), parabola(grid.size());
  for (Eigen::Index k = 0; k < grid.size(); ++k) {
    line(k) = 2.0 + 3.0 * grid.at(k);
    parabola(k) = grid.at(k) * grid.at(k);
  }
  DOUBLES_EQUAL(0.0, (grid.roughness() * line).norm(), 1e-12);
  // Second derivative 2 over a range of 1, less half an interval at each end.
  DOUBLES_EQUAL(4.0, (grid.roughness() * parabola).squaredNorm(), 0.25);
}

TEST(CircuitModel, RecordedVoltageMayTrailByALag) {
  CircuitModel model;
  model.em = Eigen::VectorXd::Constant(model.ocv.size(), 4.0);
  model.r = Eigen::MatrixXd::Constant(model.grid.size(), 2, 0.0);
  model.r.col(0).setConstant(0.01);
  model.tau = Eigen::MatrixXd::Constant(model.grid.size(), 1, 10.0);
  CellLog log;
  for (int k = 0; k < 20; ++k) {
    log.time_s.push_back(0.1 * k);
    log.current_a.push_back(k < 10 ? 0.0 : 5.0);
    log.voltage_v.push_back(4.0);
  }
  log.gap.assign(20, false);
  const MeasuredRun run = make_run(log, {});
  DOUBLES_EQUAL(3.95, simulate(model, run)(10), 1e-12);
  model.voltage_lag_s = 0.1;
  DOUBLES_EQUAL(3.95 + 0.05 * std::exp(-1.0), simulate(model, run)(10), 1e-12);
  DOUBLES_EQUAL(3.95 + 0.05 * std::exp(-3.0), simulate(model, run)(12), 1e-12);
}
