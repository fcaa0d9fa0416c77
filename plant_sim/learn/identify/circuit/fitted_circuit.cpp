// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/circuit/fitted_circuit.hpp"

#include "core/demand.hpp"
#include "learn/identify/circuit/circuit_residuals.hpp"
#include "core/parameters.hpp"

namespace voltlap::plant {

using Eigen::Index;

Eigen::VectorXd first_taus(Index branches) {
  VOLTLAP_DEMAND(branches >= 1 && branches <= static_cast<Index>(kMostCellBranches));
  if (branches == 1) return Eigen::VectorXd::Constant(1, 60.0);
  if (branches == 2) return Eigen::Vector2d(15.0, 300.0);
  if (branches == 3) return Eigen::Vector3d(3.0, 40.0, 600.0);
  return Eigen::Vector4d(2.0, 15.0, 120.0, 1000.0);
}

std::vector<Eigen::VectorXd> states_by_run(const std::vector<MeasuredRun>& runs, const Eigen::VectorXd& all,
                                           Index branches) {
  std::vector<Eigen::VectorXd> out;
  Index first = 0;
  for (const MeasuredRun& run : runs) {
    Index count = 0;
    for (Index row = 0; row < run.rows(); ++row) {
      if (run.is_reset(row) && !run.at_rest_before[static_cast<std::size_t>(row)]) count += branches;
    }
    out.push_back(all.segment(first, count));
    first += count;
  }
  VOLTLAP_DEMAND(first == all.size() && out.size() == runs.size());
  return out;
}

double mean_square(const std::vector<MeasuredRun>& runs, const std::vector<Eigen::VectorXd>& errors) {
  VOLTLAP_DEMAND(errors.size() == runs.size());
  double sum = 0.0, weight = 0.0;
  for (std::size_t k = 0; k < runs.size(); ++k) {
    sum += (runs[k].weight_s.array() * errors[k].array().square()).sum();
    weight += runs[k].weight_s.sum();
  }
  return weight > 0.0 ? sum / weight : 0.0;
}

FittedCircuit linear_fit(const std::vector<MeasuredRun>& runs, const Eigen::VectorXd& taus, const FitPriors& priors) {
  const CircuitFit fit(runs, taus.size(), priors);
  const Eigen::MatrixXd tau = taus.transpose().replicate(fit.r_count(), 1);
  FittedCircuit out;
  out.solution = fit.solve(tau);
  out.model = fit.model_of(out.solution, tau);
  out.states = states_by_run(runs, out.solution.x.tail(fit.state_count()), taus.size());
  return out;
}

TableFit table_fit(const std::vector<MeasuredRun>& runs, const Eigen::VectorXd& taus, const FitPriors& priors,
                   const CircuitModel* start) {
  constexpr int kSteps = 15;
  constexpr double kStill = 1e-4;  // of the cost
  const CircuitFit circuit(runs, taus.size(), priors);
  const CircuitResiduals cost(circuit, taus);
  const auto begin = [&]() -> Eigen::VectorXd {
    const Eigen::MatrixXd table = taus.transpose().replicate(circuit.r_count(), 1);
    if (start == nullptr) return cost.pack(circuit.solve(table), table);
    VOLTLAP_DEMAND(start->branches() == taus.size());
    LinearSolution given{Eigen::VectorXd::Zero(circuit.linear_count())};
    given.x.head(start->em.size()) = start->em;
    given.x.segment(start->em.size(), start->r.size()) = start->r.reshaped();
    Eigen::VectorXd out = cost.pack(given, start->tau);
    out.tail(ResistanceLaws::kCount) = start->laws.packed();
    return out;
  };
  const RefineResult refined = refine(cost, begin(), kSteps, kStill);
  TableFit out{{cost.model_of(refined.p), {}, states_by_run(runs, cost.states_of(refined.p), taus.size())},
               refined.cost,
               cost.doubts_of(refined.p),
               {}};
  if (out.doubts.size() == 0) return out;
  Eigen::MatrixXd whole = cost.sums(refined.p).whole();
  whole.diagonal() *= 1.0 + 1e-12;
  const Eigen::MatrixXd inverse = whole.ldlt().solve(Eigen::MatrixXd::Identity(whole.rows(), whole.cols()));
  const Eigen::VectorXd square = inverse.diagonal().segment(cost.layout().doubt(), cost.layout().doubts);
  out.doubts_sigma = (priors.noise_v2_s * square.array().max(0.0)).sqrt();
  return out;
}

std::vector<Eigen::VectorXd> errors_of(const FittedCircuit& fit, const std::vector<MeasuredRun>& runs) {
  VOLTLAP_DEMAND(fit.states.size() == runs.size());
  std::vector<Eigen::VectorXd> out;
  for (std::size_t k = 0; k < runs.size(); ++k)
    out.push_back(simulate(fit.model, runs[k], fit.states[k]) - runs[k].voltage_v);
  return out;
}

}  // namespace voltlap::plant
