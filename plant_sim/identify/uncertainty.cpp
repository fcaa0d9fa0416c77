// SPDX-License-Identifier: Apache-2.0
#include "identify/uncertainty.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace voltlap::plant {

using Eigen::Index;

double noise_density(const std::vector<TestRun>& runs, const std::vector<Eigen::VectorXd>& errors) {
  constexpr std::array kLengths{1.0, 3.0, 10.0, 30.0, 100.0, 300.0};
  constexpr double kFewestBlocks = 20.0;
  double largest = 0.0;
  for (const double length : kLengths) {
    double sum = 0.0, weight = 0.0, blocks = 0.0;
    for (std::size_t k = 0; k < runs.size(); ++k) {
      const TestRun& run = runs[k];
      double part = 0.0, part_weight = 0.0, begin = run.time_s(0);
      for (Index row = 0; row < run.rows(); ++row) {
        if (run.time_s(row) - begin >= length || run.is_reset(row)) {
          if (part_weight > 0.0) {
            sum += part * part;
            weight += part_weight;
            blocks += 1.0;
          }
          part = part_weight = 0.0;
          begin = run.time_s(row);
        }
        part += run.weight_s(row) * errors[k](row);
        part_weight += run.weight_s(row);
      }
    }
    if (weight > 0.0 && (blocks >= kFewestBlocks || largest == 0.0)) largest = std::max(largest, sum / weight);
  }
  return largest;
}

Uncertainty uncertainty_of(const CircuitCost& cost, const Eigen::VectorXd& p, double noise_v2_s) {
  const Index n = cost.parameter_count(), m = cost.residual_count(), data = cost.data_rows();
  Eigen::VectorXd residuals(m);
  CircuitCost::RowMajor jacobian(m, n);
  cost.evaluate(p.data(), residuals.data(), jacobian.data());
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(n, n), prior = information;
  information.selfadjointView<Eigen::Lower>().rankUpdate(jacobian.topRows(data).transpose());
  prior.selfadjointView<Eigen::Lower>().rankUpdate(jacobian.bottomRows(m - data).transpose());
  Eigen::MatrixXd whole = (information + prior).selfadjointView<Eigen::Lower>();
  whole.diagonal().array() += 1e-12 * whole.diagonal().maxCoeff();
  const Eigen::MatrixXd inverse = whole.ldlt().solve(Eigen::MatrixXd::Identity(n, n));
  const Eigen::MatrixXd data_part = information.selfadjointView<Eigen::Lower>();
  Uncertainty out;
  const Eigen::VectorXd bias = inverse * (jacobian.bottomRows(m - data).transpose() * residuals.tail(m - data));
  out.sigma = (noise_v2_s * inverse.diagonal().array().max(0.0) + bias.array().square()).sqrt();
  out.data_share = (inverse * data_part).diagonal().array().max(0.0).min(1.0);
  return out;
}

}  // namespace voltlap::plant
