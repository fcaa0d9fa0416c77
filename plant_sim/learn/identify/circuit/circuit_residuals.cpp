// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/circuit/circuit_residuals.hpp"

#include <algorithm>
#include <cmath>

#include "core/demand.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;

constexpr double kResistanceFloor = 1e-3;  // of the typical resistance: no recording tells less from nothing
constexpr double kMostEnergy = 120.0;      // kJ/mol, of a resistance
constexpr double kLeastOfTau = -30.0;      // kJ/mol
constexpr double kMostEntropy = 1.0;       // mV/K
constexpr double kMillivolt = 1e-3;
constexpr double kMostHysteresis = 100.0;  // mV
constexpr double kMostOfExchange = 6.0;    // of ln i_0, from what is believed of it

/// Between which values a parameter stays: resistances above a floor, time constants within what the recordings tell,
/// laws within those of any cell: no resistance rises with the temperature.
struct Bounds {
  Eigen::VectorXd low, high;
};

Bounds bounds_of(const CircuitResiduals& cost) {
  constexpr double kNone = 1e300;
  const CircuitLayout& at = cost.layout();
  const FitPriors& priors = cost.fit().priors();
  Bounds out{Eigen::VectorXd::Constant(at.size(), -kNone), Eigen::VectorXd::Constant(at.size(), kNone)};
  out.low.segment(at.em, at.tau(0) - at.em).setConstant(std::log(kResistanceFloor * priors.resistance_scale));
  out.low.segment(at.tau(0), at.state() - at.tau(0)).setConstant(std::log(priors.tau_shortest_s));
  out.high.segment(at.tau(0), at.state() - at.tau(0)).setConstant(std::log(priors.tau_bound_s));
  constexpr double kMostOff = 0.1;  // of SOC, in one step
  out.low.segment(at.doubt(), at.doubts).setConstant(-kMostOff);
  out.high.segment(at.doubt(), at.doubts).setConstant(kMostOff);
  const double exchange = priors.law_priors.mean(ResistanceLaws::kLogExchange);
  const auto energies = Eigen::Vector<double, ResistanceLaws::kLogExchange>::Constant(kMostEnergy);
  auto low = out.low.tail(ResistanceLaws::kCount), high = out.high.tail(ResistanceLaws::kCount);
  low << 0.0 * energies, exchange - kMostOfExchange, -kMostEntropy, 0.0;
  high << energies, exchange + kMostOfExchange, kMostEntropy, kMostHysteresis;
  for (Index k = 0; k < static_cast<Index>(kMostCellBranches); ++k)
    low(ResistanceLaws::time_constant(k)) = kLeastOfTau;
  return out;
}

/// Where a step leads: a resistance grows by the share itself, not by e to its power: voltages are linear in it.
Eigen::VectorXd moved(const Eigen::VectorXd& p, const Eigen::VectorXd& step, const CircuitLayout& at,
                      const Bounds& bounds) {
  constexpr double kLeastLeft = 0.1;  // of a resistance: it stays above zero
  Eigen::VectorXd out = p + step;
  const auto shares = step.segment(at.em, at.tau(0) - at.em).array();
  out.segment(at.em, shares.size()) = p.segment(at.em, shares.size()).array() + (1.0 + shares).max(kLeastLeft).log();
  return out.cwiseMax(bounds.low).cwiseMin(bounds.high);
}

/// A step for the parameters that can still move: one at its bound that would go beyond stays.
Eigen::VectorXd step_of(const Eigen::MatrixXd& whole, const Eigen::VectorXd& gradient, const Eigen::VectorXd& p,
                        const Bounds& bounds, double damping) {
  Eigen::MatrixXd damped = whole;
  damped.diagonal() *= 1.0 + damping;
  Eigen::VectorXd right = -gradient;
  for (Index k = 0; k < p.size(); ++k) {
    const bool stays = (p(k) <= bounds.low(k) && gradient(k) > 0.0) || (p(k) >= bounds.high(k) && gradient(k) < 0.0);
    if (!stays) continue;
    damped.row(k).setZero();
    damped.col(k).setZero();
    damped(k, k) = 1.0;
    right(k) = 0.0;
  }
  return damped.ldlt().solve(right);
}

}  // namespace

CircuitResiduals::CircuitResiduals(const CircuitFit& fit, Eigen::VectorXd tau_centre_s)
    : fit_(fit),
      at_(fit.layout()),
      log_centre_(tau_centre_s.array().log()),
      data_rows_(fit.rows().used),
      em_rough_(fit.ocv().roughness()),
      r_rough_(fit.r_roughness()) {
  prior_rows_ = em_rough_.rows() + r_rough_.rows() * (2 * at_.branches + 1) + at_.nodes * at_.branches +
                static_cast<Index>(fit.priors().ocv.size()) + at_.states + at_.doubts + ResistanceLaws::kCount +
                at_.branches * (at_.nodes - 1) + at_.em - 1;
  VOLTLAP_DEMAND(log_centre_.size() == at_.branches && log_centre_.allFinite());
}

Eigen::VectorXd CircuitResiduals::pack(const LinearSolution& solution, const Eigen::MatrixXd& tau_s) const {
  VOLTLAP_DEMAND(solution.x.size() == fit_.linear_count());
  VOLTLAP_DEMAND(tau_s.rows() == at_.nodes && tau_s.cols() == at_.branches);
  Eigen::VectorXd p(at_.size());
  const Index resistances = at_.tau(0) - at_.em;
  p.head(at_.em) = solution.x.head(at_.em);
  const double floor = kResistanceFloor * fit_.priors().resistance_scale;
  p.segment(at_.em, resistances) = solution.x.segment(at_.em, resistances).array().max(floor).log();
  p.segment(at_.tau(0), tau_s.size()) = tau_s.reshaped().array().log();
  p.segment(at_.state(), at_.states) = solution.x.tail(at_.states);
  p.segment(at_.doubt(), at_.doubts).setZero();
  p.tail(ResistanceLaws::kCount) = fit_.priors().laws.packed();
  if (!fit_.rows().charge_transfer) p(at_.law() + ResistanceLaws::kLogExchange) =
      fit_.priors().law_priors.mean(ResistanceLaws::kLogExchange);
  return p;
}

CircuitModel CircuitResiduals::model_of(const Eigen::VectorXd& p) const {
  VOLTLAP_DEMAND(p.size() == at_.size());
  CircuitModel model;
  model.em = p.head(at_.em);
  model.r = p.segment(at_.em, at_.tau(0) - at_.em).array().exp().reshaped(at_.nodes, at_.branches + 1);
  model.tau = p.segment(at_.tau(0), at_.nodes * at_.branches).array().exp().reshaped(at_.nodes, at_.branches);
  model.laws = fit_.priors().laws;
  model.laws.take(p.tail(ResistanceLaws::kCount));
  return model;
}

Eigen::VectorXd CircuitResiduals::plain(const double* p) const {
  Eigen::VectorXd x = Eigen::Map<const Eigen::VectorXd>(p, at_.size());
  auto logarithms = x.segment(at_.em, at_.state() - at_.em).array();
  logarithms = logarithms.exp().eval();
  return x;
}

/// No OCV falls as SOC rises.
template <class Put>
void put_falls(const double* em, Index count, double noise, const Put& put) {
  constexpr double kFalls = 1e-3;  // V
  for (Index node = 0; node + 1 < count; ++node) {
    const double rise = em[node + 1] - em[node], weight = rise < 0.0 ? noise / kFalls : 0.0;
    put(weight * rise, node, {-weight, weight, 0.0, 0.0}, 2);
  }
}

/// What is believed of the laws; of a time constant's energy, of its difference to that of the resistance.
template <class Put>
void put_laws(const FitPriors& prior, const double* laws, Index first, const Put& put) {
  constexpr double kFixed = 1e-3;  // of a sigma
  const bool fixed = prior.law_priors.fixed;
  const auto from = [&](Index k) {
    return fixed && k != ResistanceLaws::kLogExchange ? prior.laws.packed()(k) : prior.law_priors.mean(k);
  };
  for (Index k = 0; k < ResistanceLaws::kCount; ++k) {
    const double weight = std::sqrt(prior.noise_v2_s) / (prior.law_priors.sigma(k) * (fixed ? kFixed : 1.0));
    if (!fixed && ResistanceLaws::is_time_constant(k)) {
      const double apart = from(k) - from(k - 1);
      put(weight * (laws[k] - laws[k - 1] - apart), first + k - 1, {-weight, weight, 0.0, 0.0}, 2);
    } else {
      put(weight * (laws[k] - from(k)), first + k, {weight, 0.0, 0.0, 0.0}, 1);
    }
  }
}

/// One column more of a prior's row, apart from the others.
struct Beside {
  Index column = 0;
  double weight = 0.0;
};

template <class Put>
void CircuitResiduals::for_each_prior(const double* p, const Put& put) const {
  const FitPriors& prior = fit_.priors();
  const double noise = std::sqrt(prior.noise_v2_s);
  std::array<double, 4> w{};
  for (Index table = 0; table < at_.tables(); ++table) {
    const Eigen::MatrixXd& rough = table == 0 ? em_rough_ : r_rough_;
    const double weight = prior.roughness_weight(table, at_.branches);
    const bool is_resistance = table > 0 && table <= at_.branches + 1;
    const double* y = p + at_.first(table);
    const Index width = rough.cols() - rough.rows() + 1;
    for (Index row = 0; row < rough.rows(); ++row) {
      double residual = 0.0;
      for (Index k = 0; k < width; ++k) {
        const double value = is_resistance ? std::exp(y[row + k]) : y[row + k];
        const double part = weight * rough(row, row + k);
        residual += part * value;
        w[static_cast<std::size_t>(k)] = is_resistance ? part * value : part;
      }
      put(residual, at_.first(table) + row, w, width);
    }
  }
  for (Index k = 0; k < at_.branches; ++k) {
    for (Index node = at_.tau(k); node < at_.tau(k + 1); ++node) {
      w[0] = noise / prior.log_tau_sigma;
      put(w[0] * (p[node] - log_centre_(k)), node, w, 1);
    }
  }
  // A branch that vanishes between two nodes would throw what it has stored away as heat.
  constexpr double kNeighbours = 1.0;  // of ln R from one node to the next
  for (Index k = 1; k <= at_.branches; ++k) {
    for (Index node = at_.r(k); node + 1 < at_.r(k + 1); ++node) {
      w[0] = -noise / kNeighbours;
      w[1] = noise / kNeighbours;
      put(w[1] * (p[node + 1] - p[node]), node, w, 2);
    }
  }
  put_falls(p, at_.em, noise, put);
  for (const OcvKnowledge& known : prior.ocv) {
    const SocGrid::Weights em = fit_.ocv().weights(known.soc);
    const Index entropy = at_.law() + ResistanceLaws::kEntropy;
    const double warmer = kMillivolt * known.warmer_k(prior.laws);
    double residual = warmer * p[entropy] - known.voltage_v;
    for (std::size_t k = 0; k < 4; ++k) {
      residual += em.weight[k] * p[em.first + static_cast<Index>(k)];
      w[k] = noise / known.sigma_v * em.weight[k];
    }
    put(noise / known.sigma_v * residual, em.first, w, 4, {entropy, noise / known.sigma_v * warmer});
  }
  for (Index k = at_.state(); k < at_.doubt(); ++k) {
    w[0] = noise / prior.state_sigma_v;
    put(w[0] * p[k], k, w, 1);
  }
  for (std::size_t run = 0; run < prior.soc_doubts.size(); ++run) {
    const SocDoubt& doubt = prior.soc_doubts[run];
    const Index at = at_.doubt() + 2 * static_cast<Index>(run);
    w[0] = noise / doubt.offset_sigma;
    put(w[0] * (p[at] - doubt.offset_mean), at, w, 1);
    w[0] = noise / doubt.scale_sigma;
    put(w[0] * (p[at + 1] - doubt.scale_mean), at + 1, w, 1);
  }
  put_laws(prior, p + at_.law(), at_.law(), put);
}

void CircuitResiduals::evaluate(const double* p, double* residuals, double* jacobian) const {
  const Index n = at_.size();
  if (jacobian != nullptr) std::fill(jacobian, jacobian + residual_count() * n, 0.0);
  residuals_of(fit_.rows(), at_, plain(p).data(), residuals, jacobian);
  if (jacobian != nullptr) {
    Eigen::Map<RowMajor> data(jacobian, data_rows_, n);
    for (Index k = at_.em; k < at_.state(); ++k) data.col(k) *= std::exp(p[k]);
  }
  Index out = data_rows_;
  for_each_prior(p, [&](double residual, Index first, const std::array<double, 4>& w, Index count,
                        const Beside& beside = {}) {
    residuals[out] = residual;
    for (Index k = 0; jacobian != nullptr && k < count; ++k)
      jacobian[out * n + first + k] = w[static_cast<std::size_t>(k)];
    if (jacobian != nullptr) jacobian[out * n + beside.column] += beside.weight;
    ++out;
  });
}

CircuitResiduals::Sums CircuitResiduals::sums(const Eigen::VectorXd& p) const {
  VOLTLAP_DEMAND(p.size() == at_.size());
  NormalSums data = sums_of(fit_.rows(), at_, plain(p.data()).data(), true);
  const Index n = at_.size();
  Eigen::VectorXd scale = Eigen::VectorXd::Ones(n);
  const Index logarithms = at_.state() - at_.em;
  scale.segment(at_.em, logarithms) = p.segment(at_.em, logarithms).array().exp();
  Sums out{std::move(data.rest), std::move(data.load), Eigen::MatrixXd::Zero(n, n), {}, Eigen::VectorXd::Zero(n),
           data.rest_square, data.load_square, 0.0, data.rest_rows, data.load_rows};
  for (Eigen::MatrixXd* part : {&out.rest, &out.load})
    *part = (part->array() * (scale * scale.transpose()).array()).matrix();
  for_each_prior(p.data(), [&](double residual, Index first, const std::array<double, 4>& w, Index count,
                               const Beside& beside = {}) {
    out.prior_square += residual * residual;
    const auto f = Eigen::Map<const Eigen::Vector4d>(w.data()).head(count);
    out.prior_gradient.segment(first, count) += residual * f;
    out.prior.block(first, first, count, count) += f * f.transpose();
    if (beside.weight == 0.0) return;
    out.prior_gradient(beside.column) += residual * beside.weight;
    out.prior(beside.column, beside.column) += beside.weight * beside.weight;
    out.prior.col(beside.column).segment(first, count) += beside.weight * f;
    out.prior.row(beside.column).segment(first, count) += beside.weight * f.transpose();
  });
  out.gradient = data.gradient.cwiseProduct(scale) + out.prior_gradient;
  return out;
}

RefineResult refine(const CircuitResiduals& cost, const Eigen::VectorXd& start, int iterations_max, double tolerance) {
  constexpr int kMostTrials = 12;
  const CircuitLayout& at = cost.layout();
  VOLTLAP_DEMAND(start.size() == at.size() && tolerance >= 0.0);
  const Bounds bounds = bounds_of(cost);
  RefineResult out{start.cwiseMax(bounds.low).cwiseMin(bounds.high)};
  CircuitResiduals::Sums sums = cost.sums(out.p);
  out.cost = sums.cost();
  double damping = 1e-4, growth = 2.0;
  for (; out.iterations < iterations_max && !out.converged; ++out.iterations) {
    const Eigen::MatrixXd whole = sums.whole();
    bool accepted = false;
    for (int trial = 0; trial < kMostTrials && !accepted; ++trial) {
      const Eigen::VectorXd step = step_of(whole, sums.gradient, out.p, bounds, damping);
      // A factor of e at most in any time constant: beyond it the straight line means nothing.
      const double longest = step.segment(at.tau(0), at.state() - at.tau(0)).cwiseAbs().maxCoeff();
      const Eigen::VectorXd taken = step * std::min(1.0, 1.0 / std::max(longest, 1e-12));
      const double predicted = -2.0 * sums.gradient.dot(taken) - taken.dot(whole * taken);
      const Eigen::VectorXd there = moved(out.p, taken, at, bounds);
      CircuitResiduals::Sums next = cost.sums(there);
      const double gained = out.cost - next.cost();
      if (predicted <= tolerance * out.cost && std::abs(gained) <= tolerance * out.cost) out.converged = true;
      if (gained > 0.0) {
        accepted = true;
        out.p = there;
        out.cost = next.cost();
        sums = std::move(next);
        // H. B. Nielsen, IMM-REP-1999-05: the better the prediction, the less damping, without a jump.
        damping = std::max(1e-9, damping * std::max(0.1, 1.0 - std::pow(2.0 * gained / predicted - 1.0, 3)));
        growth = 2.0;
      } else {
        if (out.converged) break;
        damping = std::max(1e-6, growth * damping);
        growth *= 2.0;
      }
    }
    if (!accepted) break;
  }
  VOLTLAP_DEMAND(out.p.size() == start.size());
  return out;
}

}  // namespace voltlap::plant
