// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/circuit/circuit_residuals.hpp"

#include <cmath>

#include "plant_sim/learn/identify/known_cell.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(CircuitResiduals) {
  std::vector<MeasuredRun> runs;
  FitPriors priors;

  /// A short drive with everything in it: unequal steps, a gap, a charge, temperature, all three holds.
  void setup() override {
    CellLog log;
    log.path = "short drive";
    double t = 0.0, soc = 0.9;
    for (int k = 0; k < 400; ++k) {
      t += k % 7 == 0 ? 5.0 : 1.0;
      const double i = 40.0 * std::sin(0.05 * k) + (k % 50 < 20 ? 30.0 : 0.0);
      soc -= i * 1e-4;
      log.time_s.push_back(t);
      log.current_a.push_back(i);
      log.voltage_v.push_back(3.5 + 0.5 * soc - 2e-3 * i);
      log.temperature_c.push_back(20.0 + 0.02 * k);
    }
    log.gap.assign(400, false);
    log.gap[200] = true;
    RunOptions options;
    options.capacity_ah = 1.0;
    options.anchor = {0, 0.9, "test"};
    for (const CurrentHold hold : {CurrentHold::kNext, CurrentHold::kPrevious, CurrentHold::kLinear}) {
      options.hold = hold;
      runs.push_back(make_run(log, options));
      runs.back().at_rest_before[0] = false;
    }
    priors.resistance_scale = 2e-3;
    priors.ocv.push_back({0.5, 3.7, 2e-3});
    priors.ocv.push_back({0.6, 3.75, 2e-3, -5.0});
    priors.laws = assumed_laws(25.0);
    priors.laws.branch_kj_per_mol = {{{20.0, 5.0}, {30.0, 15.0}}};
    priors.laws.exchange_a = 30.0;
    priors.laws.entropy_mv_per_k = 0.2;
    priors.laws.hysteresis_mv = 10.0;
    priors.laws.hysteresis_per_soc = 15.0;
    priors.law_priors.mean = priors.laws.packed();
  }
};

TEST(CircuitResiduals, JacobianAgreesWithDifferences) {
  for (Eigen::Index branches = 1; branches <= 3; ++branches) {
    const CircuitFit fit(runs, branches, priors);
    Eigen::VectorXd taus(branches);
    for (Eigen::Index k = 0; k < branches; ++k) taus(k) = 5.0 * std::pow(8.0, static_cast<double>(k));
    const CircuitResiduals cost(fit, taus);
    LinearSolution start{Eigen::VectorXd::Constant(fit.linear_count(), 1e-3), 0.0};
    start.x.head(fit.em_count()).setLinSpaced(3.4, 4.1);
    const Eigen::VectorXd p = cost.pack(start, taus.transpose().replicate(fit.r_count(), 1));
    Eigen::VectorXd residuals(cost.residual_count()), up = residuals, down = residuals;
    CircuitResiduals::RowMajor jacobian(cost.residual_count(), cost.parameter_count());
    cost.evaluate(p.data(), residuals.data(), jacobian.data());
    const double scale = jacobian.cwiseAbs().maxCoeff();
    for (Eigen::Index k = 0; k < p.size(); ++k) {
      const double h = 1e-5;
      Eigen::VectorXd at = p;
      at(k) += h;
      cost.evaluate(at.data(), up.data(), nullptr);
      at(k) -= 2 * h;
      cost.evaluate(at.data(), down.data(), nullptr);
      DOUBLES_EQUAL(0.0, ((up - down) / (2 * h) - jacobian.col(k)).cwiseAbs().maxCoeff(), 1e-8 * scale);
    }
  }
}

TEST(CircuitResiduals, AgreesWithTheLinearFitAtItsSolution) {
  const CircuitFit fit(runs, 2, priors);
  const Eigen::Vector2d taus(5.0, 60.0);
  const Eigen::MatrixXd table = taus.transpose().replicate(fit.r_count(), 1);
  const LinearSolution solution = fit.solve(table);
  const CircuitResiduals cost(fit, taus);
  Eigen::VectorXd residuals(cost.residual_count());
  const Eigen::VectorXd p = cost.pack(solution, table);
  cost.evaluate(p.data(), residuals.data(), nullptr);
  // Beside what both have the full fit draws ln R of neighbouring nodes of a branch together.
  double neighbours = 0.0;
  const CircuitLayout at = cost.layout();
  for (Eigen::Index k = 1; k <= 2; ++k) {
    for (Eigen::Index node = at.r(k); node + 1 < at.r(k + 1); ++node)
      neighbours += priors.noise_v2_s * std::pow(p(node + 1) - p(node), 2);
  }
  // And no OCV falls.
  double falls = 0.0;
  for (Eigen::Index node = 0; node + 1 < at.em; ++node)
    falls += priors.noise_v2_s * std::pow(std::min(0.0, p(node + 1) - p(node)) / 1e-3, 2);
  DOUBLES_EQUAL(solution.cost + neighbours + falls, residuals.squaredNorm(), 1e-3 * solution.cost);
}

TEST(CircuitResiduals, ResidualsAreThoseOfTheSimulation) {
  const CircuitFit fit(runs, 2, priors);
  const Eigen::Vector2d taus(5.0, 60.0);
  const CircuitResiduals cost(fit, taus);
  LinearSolution any{Eigen::VectorXd::Constant(fit.linear_count(), 1e-3), 0.0};
  const Eigen::VectorXd p = cost.pack(any, taus.transpose().replicate(fit.r_count(), 1));
  Eigen::VectorXd residuals(cost.residual_count());
  cost.evaluate(p.data(), residuals.data(), nullptr);
  const Eigen::VectorXd error = simulate(cost.model_of(p), runs[0], cost.states_of(p)) - runs[0].voltage_v;
  Eigen::Index out = 0;
  for (Eigen::Index row = 0; row < runs[0].rows(); ++row) {
    if (runs[0].weight_s(row) > 0.0)
      DOUBLES_EQUAL(std::sqrt(runs[0].weight_s(row)) * error(row), residuals(out++), 1e-12);
  }
}

TEST(CircuitResiduals, LinearFitKeepsResistancesFromGoingNegative) {
  for (MeasuredRun& run : runs)
    run.voltage_v = run.voltage_v.array() + 5e-3 * run.current_a.array();  // a cell that gives
  const CircuitFit fit(runs, 2, priors);
  const LinearSolution solution = fit.solve(Eigen::RowVector2d(5.0, 60.0).replicate(fit.r_count(), 1));
  CHECK(solution.x.segment(fit.em_count(), 3 * fit.r_count()).minCoeff() >= 0.0);
}
