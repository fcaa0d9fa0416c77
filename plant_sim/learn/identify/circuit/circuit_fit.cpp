// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/circuit/circuit_fit.hpp"

#include <algorithm>
#include <cmath>

#include "core/demand.hpp"
#include "learn/identify/circuit/nelder_mead.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;

constexpr double kScale = 2e-3;  // s [V s^0.5]
constexpr double kConstant = 1e-6;  // slope of a constant table that counts as one s, in its unit

/// x that is least in x^T normal x - 2 right^T x with x >= 0 from `first` to `last` (exclusive): those that would be
/// negative are held at zero, until no more would.
Eigen::VectorXd solve_not_negative(const Eigen::MatrixXd& normal, const Eigen::VectorXd& right, Index first,
                                   Index last) {
  constexpr int kPasses = 30;
  const Index count = right.size();
  std::vector<bool> held(static_cast<std::size_t>(count), false);
  Eigen::VectorXd x;
  for (int pass = 0; pass < kPasses; ++pass) {
    std::vector<Index> free;
    for (Index k = 0; k < count; ++k) {
      if (!held[static_cast<std::size_t>(k)]) free.push_back(k);
    }
    const Eigen::VectorXd part = normal(free, free).ldlt().solve(right(free));
    x = Eigen::VectorXd::Zero(count);
    for (std::size_t k = 0; k < free.size(); ++k) x(free[k]) = part(static_cast<Index>(k));
    bool all_well = true;
    for (Index k = first; k < last; ++k) {
      if (x(k) < 0.0) {
        held[static_cast<std::size_t>(k)] = true;
        x(k) = 0.0;
        all_well = false;
      }
    }
    if (all_well) break;
  }
  return x;
}

}  // namespace

double FitPriors::roughness_weight(Index table, Index branches) const {
  if (roughness_weights.size() > 0) return roughness_weights(table);
  if (table == 0) return kScale / (em_roughness_v * (constant ? smoothness : 1.0));
  const double unit = table <= branches + 1 ? resistance_scale : log_tau_roughness;
  return kScale / ((constant ? kConstant : smoothness) * unit);
}

CircuitFit::CircuitFit(const std::vector<MeasuredRun>& runs, Index branches, FitPriors priors, SocGrid grid)
    : runs_(runs),
      grid_(std::move(grid)),
      branches_(branches),
      priors_(std::move(priors)),
      rows_(runs, ocv_, grid_, branches, priors_.laws, priors_.soc_doubts),
      em_rough_(ocv_.roughness()),
      r_rough_(priors_.constant ? grid_.slopes() : grid_.roughness()) {
  VOLTLAP_DEMAND(!runs_.empty() && branches_ >= 1);
  VOLTLAP_DEMAND(priors_.resistance_scale > 0.0 && priors_.noise_v2_s >= 0.0);
}

void CircuitFit::add_priors(Eigen::MatrixXd& normal, Eigen::VectorXd& right, double& square) const {
  const Index em = em_count(), r = r_count();
  const double m = priors_.roughness_weight(0, branches_);
  normal.topLeftCorner(em, em) += m * m * em_rough_.transpose() * em_rough_;
  const Eigen::MatrixXd rough = r_rough_.transpose() * r_rough_;
  for (Index k = 0; k <= branches_; ++k) {
    const double c = priors_.roughness_weight(k + 1, branches_);
    normal.block(em + k * r, em + k * r, r, r) += c * c * rough;
  }
  for (const OcvKnowledge& known : priors_.ocv) {
    const SocGrid::Weights w = ocv_.weights(known.soc);
    const double weight = priors_.noise_v2_s / (known.sigma_v * known.sigma_v);
    const Eigen::Map<const Eigen::Vector4d> f(w.weight.data());
    normal.block<4, 4>(w.first, w.first) += weight * f * f.transpose();
    const double voltage_v = known.voltage_v - priors_.laws.reversible_v(known.warmer_k(priors_.laws));
    right.segment<4>(w.first) += weight * voltage_v * f;
    square += weight * voltage_v * voltage_v;
  }
  normal.diagonal().tail(state_count()).array() +=
      priors_.noise_v2_s / (priors_.state_sigma_v * priors_.state_sigma_v);
}

LinearSolution CircuitFit::solve(const Eigen::MatrixXd& tau_s) const {
  const CircuitLayout at = layout();
  VOLTLAP_DEMAND(tau_s.rows() == r_count() && tau_s.cols() == branches_);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(at.size());
  x.segment(at.tau(0), tau_s.size()) = tau_s.reshaped();
  x.tail(ResistanceLaws::kCount) = priors_.laws.packed();
  const NormalSums sums = sums_of(rows_, at, x.data(), false);
  std::vector<Index> linear;
  for (Index k = 0; k < at.size(); ++k) {
    if (k < at.tau(0) || (k >= at.state() && k < at.doubt())) linear.push_back(k);
  }
  // All resistances are zero here: the error is the voltage itself, with what the charge transfer takes.
  Eigen::MatrixXd normal = (sums.rest + sums.load)(linear, linear);
  Eigen::VectorXd right = -sums.gradient(linear);
  double square = sums.rest_square + sums.load_square;
  add_priors(normal, right, square);
  normal.diagonal() *= 1.0 + 1e-12;
  const Index first = em_count(), last = em_count() + r_count() * (branches_ + 1);
  LinearSolution out{solve_not_negative(normal, right, first, last)};
  VOLTLAP_DEMAND(out.x.size() == linear_count());
  out.cost = square - 2.0 * right.dot(out.x) + out.x.dot(normal * out.x);
  return out;
}

double CircuitFit::cost_of_taus(const Eigen::VectorXd& log_tau) const {
  // Branches keep their order and a distance of 1.5; outside this and shortest to longest a wall rises.
  double wall = 0.0;
  for (Index k = 0; k < log_tau.size(); ++k) {
    const double low = k == 0 ? std::log(priors_.tau_shortest_s) : log_tau(k - 1) + std::log(1.5);
    wall += std::max(0.0, low - log_tau(k)) + std::max(0.0, log_tau(k) - std::log(priors_.tau_longest_s));
  }
  const Eigen::VectorXd tau = log_tau.array().min(std::log(5e4)).max(std::log(1e-2)).exp();
  return solve(tau.transpose().replicate(r_count(), 1)).cost * (1.0 + wall);
}

Eigen::VectorXd CircuitFit::search_taus(const Eigen::VectorXd& start_s, int evaluations) const {
  VOLTLAP_DEMAND(start_s.size() == branches_ && evaluations > 0);
  const auto cost = [&](const Eigen::VectorXd& log_tau) { return cost_of_taus(log_tau); };
  return nelder_mead_minimum(cost, start_s.array().log().matrix(), 0.7, evaluations).array().exp();
}

CircuitModel CircuitFit::model_of(const LinearSolution& solution, const Eigen::MatrixXd& tau_s) const {
  VOLTLAP_DEMAND(solution.x.size() == linear_count());
  CircuitModel model;
  model.em = solution.x.head(em_count());
  model.r = Eigen::Map<const Eigen::MatrixXd>(solution.x.data() + em_count(), r_count(), branches_ + 1);
  model.tau = tau_s;
  model.laws = priors_.laws;
  return model;
}

}  // namespace voltlap::plant
