// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/recording/measured_run.hpp"

#include <algorithm>

#include "learn/identify/circuit/circuit_model.hpp"
#include "plant_sim/learn/identify/known_cell.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(MeasuredRun) {
  KnownCell cell;
};

TEST(MeasuredRun, RecordingThatBeginsFullAndRestingIsFullAtItsFirstRow) {
  const auto rows = full_charges(cell.record(cell.pulse_plan(30.0, 600)));
  LONGS_EQUAL(1, rows.size());
  LONGS_EQUAL(0, rows[0]);
}

TEST(MeasuredRun, EndOfAChargeAtTheHighestVoltageIsFull) {
  std::vector<double> plan(600, 0.0);
  plan.insert(plan.end(), 3000, -30.0);
  plan.insert(plan.end(), 600, 0.0);
  plan.insert(plan.end(), 3000, 30.0);
  plan.insert(plan.end(), 600, 0.0);
  plan.insert(plan.end(), 1000, -30.0);  // not back to the top
  plan.insert(plan.end(), 600, 0.0);
  const auto rows = full_charges(cell.record(plan, 0.1));
  LONGS_EQUAL(1, rows.size());
  LONGS_EQUAL(3599, rows[0]);
}

TEST(MeasuredRun, SocIsCountedFromItsAnchorAndIsOneAgainAtEveryFullCharge) {
  const CellLog log = cell.record(std::vector<double>(3601, 30.0));
  RunOptions options;
  options.capacity_ah = 30.0;
  DOUBLES_EQUAL(0.0, make_run(log, options).soc(3600), 1e-9);
  options.anchor = {3600, 0.25, "test"};
  DOUBLES_EQUAL(1.25, make_run(log, options).soc(0), 1e-9);
  options.anchor = {0, 1.0, "full charge"};
  options.full_rows = {1800};
  DOUBLES_EQUAL(1.0, make_run(log, options).soc(1800), 1e-12);
  DOUBLES_EQUAL(0.5, make_run(log, options).soc(3600), 1e-9);
}

TEST(MeasuredRun, MeansKeepTimeWeightChargeAndTheVoltageOfTheCircuit) {
  const CellLog log = cell.record(cell.pulse_plan(30.0, 1800));
  RunOptions options;
  options.capacity_ah = cell.capacity_ah;
  MeasuredRun whole = make_run(log, options);
  CircuitModel model;
  model.em = Eigen::VectorXd::LinSpaced(model.ocv.size(), 3.0, 4.2);
  model.r = Eigen::MatrixXd::Constant(model.grid.size(), 3, 1e-3);
  model.tau = Eigen::MatrixXd::Constant(model.grid.size(), 2, 50.0);
  whole.voltage_v = simulate(model, whole);
  const MeasuredRun few = averaged(whole, 0.03);
  CHECK(few.rows() < whole.rows() / 4);
  DOUBLES_EQUAL(whole.weight_s.sum(), few.weight_s.sum(), 1e-6);
  DOUBLES_EQUAL(whole.soc.dot(whole.weight_s), few.soc.dot(few.weight_s), 1e-6);
  // Mean of the voltage against voltage at the mean: an exponential bends by 4e-5 of itself within 3 % of its time.
  CHECK((simulate(model, few) - few.voltage_v).cwiseAbs().maxCoeff() < 2e-5);
}

TEST(MeasuredRun, RowsAroundAStepAndGlitchesStayByThemselves) {
  CellLog log = cell.record(cell.pulse_plan(30.0, 1800));
  log.voltage_v[250] -= 0.5;
  RunOptions options;
  options.capacity_ah = cell.capacity_ah;
  const MeasuredRun whole = make_run(log, options), few = averaged(whole, 0.03);
  const auto stays = [&](double t) { return (few.time_s.array() == t).any(); };
  for (const double t : {249.0, 250.0, 251.0, 299.0, 300.0, 301.0}) CHECK(stays(t));
  CHECK(!stays(200.0) || !stays(201.0));
}

TEST(MeasuredRun, ThinningKeepsTimeWeightAndTheSimulatedVoltage) {
  const CellLog log = cell.record(cell.pulse_plan(30.0, 1800));
  RunOptions options;
  options.capacity_ah = cell.capacity_ah;
  const MeasuredRun whole = make_run(log, options), thin = thinned(whole, 0.05);
  CHECK(thin.rows() < whole.rows() / 2);
  DOUBLES_EQUAL(whole.weight_s.sum(), thin.weight_s.sum(), 1e-6);
  CircuitModel model;
  model.em = Eigen::VectorXd::LinSpaced(model.ocv.size(), 3.0, 4.2);
  model.r = Eigen::MatrixXd::Constant(model.grid.size(), 3, 1e-3);
  model.tau = Eigen::MatrixXd::Constant(model.grid.size(), 2, 50.0);
  const Eigen::VectorXd all = simulate(model, whole), few = simulate(model, thin);
  for (Eigen::Index row = 0, at = 0; row < thin.rows(); ++row) {
    while (whole.time_s(at) < thin.time_s(row)) ++at;
    DOUBLES_EQUAL(all(at), few(row), 1e-12);
  }
}

TEST(MeasuredRun, RowOfMeansWithAStepInsideHasNoWeight) {
  CellLog log = cell.record(std::vector<double>(100, 30.0));
  for (std::size_t row = 51; row < 100; ++row) log.current_a[row] = 0.0;
  log.current_a[50] = 12.0;
  RunOptions options;
  options.hold = CurrentHold::kLinear;
  DOUBLES_EQUAL(0.0, make_run(log, options).weight_s(50), 0.0);
  DOUBLES_EQUAL(1.0, make_run(log, options).weight_s(51), 0.0);
  options.hold = CurrentHold::kNext;
  DOUBLES_EQUAL(1.0, make_run(log, options).weight_s(50), 0.0);
}

TEST(MeasuredRun, RowWithoutVoltageHasNoWeight) {
  CellLog log = cell.record(std::vector<double>(100, 30.0));
  log.voltage_v[50] = std::nan("");
  const MeasuredRun run = make_run(log, {});
  DOUBLES_EQUAL(0.0, run.weight_s(50), 0.0);
  CHECK(run.voltage_v.allFinite());
}

TEST(MeasuredRun, ACycleThatNearlyClosesHasItsRestDividedOverTheCharge) {
  // 30 Ah drawn, 29.7 Ah put back, full again.
  std::vector<double> plan(3600, 30.0);
  plan.insert(plan.end(), 3600, -29.7);
  const CellLog log = cell.record(plan);
  RunOptions options;
  options.capacity_ah = 30.0;
  options.full_rows = {log.rows() - 1};
  const MeasuredRun run = make_run(log, options);
  DOUBLES_EQUAL(1.0, run.soc(run.rows() - 1), 1e-12);
  for (Eigen::Index row = 3601; row < run.rows(); ++row) CHECK(run.soc(row) - run.soc(row - 1) < 5e-4);  // no jump
  CHECK(run.weight_s.tail(3000).minCoeff() > 0.0);
}

TEST(MeasuredRun, ChargeThatNobodyRecordedLeavesTheRowsFromTheLowestPointUnused) {
  // 30 Ah drawn, 25 Ah put back, full all the same.
  std::vector<double> plan(3600, 30.0);
  plan.insert(plan.end(), 3600, -25.0);
  const CellLog log = cell.record(plan);
  RunOptions options;
  options.capacity_ah = 30.0;
  options.full_rows = {log.rows() - 1};
  const MeasuredRun run = make_run(log, options);
  DOUBLES_EQUAL(0.0, run.weight_s.segment(3600, 3500).maxCoeff(), 0.0);
  CHECK(run.weight_s.head(3599).minCoeff() > 0.0);
  DOUBLES_EQUAL(1.0, run.soc(run.rows() - 1), 1e-12);
}

TEST(MeasuredRun, MeansOfASecondKeepWeightChargeAndGaps) {
  cell.row_s = 0.1;
  CellLog log = cell.record(cell.pulse_plan(30.0, 60, 0.9));
  log.gap[500] = true;
  RunOptions options;
  options.capacity_ah = cell.capacity_ah;
  const MeasuredRun whole = make_run(log, options), few = coarsened(whole, 1.0);
  CHECK(few.rows() < whole.rows() / 8);
  DOUBLES_EQUAL(whole.weight_s.sum(), few.weight_s.sum(), 1e-6);
  DOUBLES_EQUAL(whole.current_a.dot(whole.weight_s), few.current_a.dot(few.weight_s), 1e-6);
  LONGS_EQUAL(std::count(whole.reset.begin(), whole.reset.end(), true),
              std::count(few.reset.begin(), few.reset.end(), true));
}
