// SPDX-License-Identifier: Apache-2.0
// A circuit with what belongs to it beside its tables, and its errors; quick fits with time constants that do not
// depend on SOC.
#pragma once
#include <Eigen/Dense>
#include <vector>

#include "learn/identify/circuit/circuit_fit.hpp"

namespace voltlap::plant {

struct FittedCircuit {
  CircuitModel model;
  LinearSolution solution;              ///< of a linear fit
  std::vector<Eigen::VectorXd> states;  ///< free states, run by run
};

/// Where a search for time constants begins.
[[nodiscard]] Eigen::VectorXd first_taus(Eigen::Index branches);
[[nodiscard]] FittedCircuit linear_fit(const std::vector<MeasuredRun>& runs, const Eigen::VectorXd& taus,
                                  const FitPriors& priors);
/// All parameters free from a linear fit's answer on, time constants and laws too, in a few steps: near enough to
/// compare.
struct TableFit {
  FittedCircuit fit;
  double cost = 0.0;  ///< with what is believed beforehand [V^2 s]
  Eigen::VectorXd doubts, doubts_sigma;  ///< o and c of each run, where SOC is in doubt
};
/// `start`: a model to begin with instead.
[[nodiscard]] TableFit table_fit(const std::vector<MeasuredRun>& runs, const Eigen::VectorXd& taus,
                                 const FitPriors& priors, const CircuitModel* start = nullptr);
/// Free states of each run, out of those of all.
[[nodiscard]] std::vector<Eigen::VectorXd> states_by_run(const std::vector<MeasuredRun>& runs,
                                                         const Eigen::VectorXd& all, Eigen::Index branches);

/// Model less recording, run by run [V].
[[nodiscard]] std::vector<Eigen::VectorXd> errors_of(const FittedCircuit& fit, const std::vector<MeasuredRun>& runs);
/// Weighted by time [V^2].
[[nodiscard]] double mean_square(const std::vector<MeasuredRun>& runs, const std::vector<Eigen::VectorXd>& errors);

}  // namespace voltlap::plant
