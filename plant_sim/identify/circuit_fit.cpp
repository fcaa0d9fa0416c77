// SPDX-License-Identifier: Apache-2.0
#include "identify/circuit_fit.hpp"

#include <algorithm>
#include <cmath>

namespace voltlap::plant {
namespace {

using Eigen::Index;

constexpr double kScale = 2e-3;  // s [V s^0.5]
constexpr Index kChunk = 256;

/// N += C^T C and so on for the columns of C that are not all zero: in a discharge only few nodes act at a time.
void add_chunk(const Eigen::MatrixXd& chunk, Index rows, const Eigen::VectorXd& y, Eigen::MatrixXd& n,
               Eigen::VectorXd& g) {
  constexpr double kNothing = 1e-9;
  std::vector<Index> active;
  for (Index column = 0; column < chunk.cols(); ++column) {
    if (chunk.col(column).head(rows).cwiseAbs().maxCoeff() > kNothing) active.push_back(column);
  }
  const auto count = static_cast<Index>(active.size());
  Eigen::MatrixXd dense(rows, count);
  for (Index k = 0; k < count; ++k) dense.col(k) = chunk.col(active[static_cast<std::size_t>(k)]).head(rows);
  Eigen::MatrixXd product = Eigen::MatrixXd::Zero(count, count);
  product.selfadjointView<Eigen::Lower>().rankUpdate(dense.transpose());
  const Eigen::VectorXd right = dense.transpose() * y.head(rows);
  for (Index a = 0; a < count; ++a) {
    g(active[static_cast<std::size_t>(a)]) += right(a);
    for (Index b = 0; b <= a; ++b)
      n(active[static_cast<std::size_t>(a)], active[static_cast<std::size_t>(b)]) += product(a, b);
  }
}

/// Nelder and Mead's simplex in a few dimensions.
template <class Function>
Eigen::VectorXd simplex_minimum(const Function& f, const Eigen::VectorXd& start, double size, int evaluations) {
  const Index n = start.size();
  std::vector<std::pair<double, Eigen::VectorXd>> points{{f(start), start}};
  for (Index k = 0; k < n; ++k) {
    Eigen::VectorXd at = start;
    at(k) += size;
    points.emplace_back(f(at), at);
  }
  const auto by_value = [](const auto& a, const auto& b) { return a.first < b.first; };
  for (int used = static_cast<int>(n) + 1; used < evaluations;) {
    std::sort(points.begin(), points.end(), by_value);
    if ((points.back().second - points.front().second).cwiseAbs().maxCoeff() < 0.02) break;
    Eigen::VectorXd centre = Eigen::VectorXd::Zero(n);
    for (Index k = 0; k < n; ++k) centre += points[static_cast<std::size_t>(k)].second / static_cast<double>(n);
    auto& worst = points.back();
    const auto attempt = [&](double factor) {
      const Eigen::VectorXd at = centre + factor * (worst.second - centre);
      ++used;
      return std::pair{f(at), at};
    };
    const auto reflected = attempt(-1.0);
    if (reflected.first < points.front().first) {
      const auto further = attempt(-2.0);
      worst = further.first < reflected.first ? further : reflected;
    } else if (reflected.first < points[static_cast<std::size_t>(n) - 1].first) {
      worst = reflected;
    } else {
      const auto inner = attempt(reflected.first < worst.first ? -0.5 : 0.5);
      if (inner.first < std::min(worst.first, reflected.first)) {
        worst = inner;
        continue;
      }
      for (std::size_t k = 1; k < points.size(); ++k) {
        points[k].second = 0.5 * (points[k].second + points[0].second);
        points[k].first = f(points[k].second);
        ++used;
      }
    }
  }
  return std::min_element(points.begin(), points.end(), by_value)->second;
}

}  // namespace

CircuitFit::CircuitFit(const std::vector<TestRun>& runs, Index branches, FitPriors priors)
    : runs_(runs),
      branches_(branches),
      priors_(std::move(priors)),
      em_rough_(ocv_.roughness()),
      r_rough_(grid_.roughness()) {
  for (const TestRun& run : runs_) {
    for (Index row = 0; row < run.rows(); ++row) {
      if (run.is_reset(row) && !run.at_rest_before[static_cast<std::size_t>(row)]) states_ += branches_;
    }
  }
}

void CircuitFit::add_run(const TestRun& run, Index first_state, const Eigen::MatrixXd& tau_s,
                         Normal& normal) const {
  const Index em = em_count(), r = r_count(), k_count = branches_, columns = linear_count();
  Eigen::MatrixXd chunk = Eigen::MatrixXd::Zero(kChunk, columns);
  Eigen::VectorXd y(kChunk);
  // Responses of the branches: to each node's resistance, and to each free state.
  Eigen::MatrixXd state = Eigen::MatrixXd::Zero(r, k_count);
  Eigen::VectorXd decay = Eigen::VectorXd::Ones(k_count);
  Index filled = 0, open_state = -1, next_state = first_state;
  for (Index row = 0; row < run.rows(); ++row) {
    const SocGrid::Place p = grid_.find(run.soc(row));
    const double scale = run.resistance_scale(row);
    if (run.is_reset(row)) {
      state.setZero();
      decay.setOnes();
      open_state = run.at_rest_before[static_cast<std::size_t>(row)] ? -1 : next_state;
      if (open_state >= 0) next_state += k_count;
    } else {
      const SocGrid::Place middle = grid_.find(0.5 * (run.soc(row) + run.soc(row - 1)));
      const SocGrid::Place q = grid_.find(run.soc(row - 1));
      const double begin = run.resistance_scale(row - 1) * run.current_begin_a(row),
                   end = scale * run.current_end_a(row);
      for (Index k = 0; k < k_count; ++k) {
        const double tau =
            tau_s(middle.node, k) + middle.fraction * (tau_s(middle.node + 1, k) - tau_s(middle.node, k));
        const IntervalResponse w = interval_response(run.dt_s(row), tau);
        state.col(k) *= w.a;
        state(q.node, k) += w.g0 * begin * (1.0 - q.fraction);
        state(q.node + 1, k) += w.g0 * begin * q.fraction;
        state(p.node, k) += w.g1 * end * (1.0 - p.fraction);
        state(p.node + 1, k) += w.g1 * end * p.fraction;
        decay(k) *= w.a;
      }
    }
    if (run.weight_s(row) <= 0.0) continue;
    const double root = std::sqrt(run.weight_s(row));
    const SocGrid::Place e = ocv_.find(run.soc(row));
    auto line = chunk.row(filled);
    line.setZero();
    line(e.node) = root * (1.0 - e.fraction);
    line(e.node + 1) = root * e.fraction;
    const double i = -root * scale * run.current_a(row);
    line(em + p.node) = i * (1.0 - p.fraction);
    line(em + p.node + 1) = i * p.fraction;
    for (Index k = 0; k < k_count; ++k) {
      line.segment(em + (k + 1) * r, r) = -root * state.col(k).transpose();
      if (open_state >= 0) line(em + (k_count + 1) * r + open_state + k) = -root * decay(k);
    }
    y(filled) = root * run.voltage_v(row);
    normal.yy += y(filled) * y(filled);
    if (++filled == kChunk) {
      add_chunk(chunk, filled, y, normal.n, normal.g);
      filled = 0;
    }
  }
  if (filled > 0) add_chunk(chunk, filled, y, normal.n, normal.g);
}

void CircuitFit::add_priors(Normal& normal) const {
  const Index em = em_count(), r = r_count();
  const double m = kScale / priors_.em_roughness_v;
  normal.n.topLeftCorner(em, em) += m * m * em_rough_.transpose() * em_rough_;
  const double c = kScale / (priors_.smoothness * priors_.resistance_scale);
  const Eigen::MatrixXd smooth = c * c * r_rough_.transpose() * r_rough_;
  for (Index k = 0; k <= branches_; ++k) normal.n.block(em + k * r, em + k * r, r, r) += smooth;
  for (const OcvKnowledge& known : priors_.ocv) {
    const SocGrid::Place p = ocv_.find(known.soc);
    const double weight = priors_.noise_v2_s / (known.sigma_v * known.sigma_v),
                 f[2] = {1.0 - p.fraction, p.fraction};
    for (Index a = 0; a < 2; ++a) {
      for (Index b = 0; b < 2; ++b) normal.n(p.node + a, p.node + b) += weight * f[a] * f[b];
      normal.g(p.node + a) += weight * f[a] * known.voltage_v;
    }
    normal.yy += weight * known.voltage_v * known.voltage_v;
  }
  const double state = priors_.noise_v2_s / (priors_.state_sigma_v * priors_.state_sigma_v);
  normal.n.diagonal().tail(states_).array() += state;
}

LinearSolution CircuitFit::solve(const Eigen::MatrixXd& tau_s) const {
  Normal normal{Eigen::MatrixXd::Zero(linear_count(), linear_count()), Eigen::VectorXd::Zero(linear_count())};
  Index state = 0;
  for (const TestRun& run : runs_) {
    add_run(run, state, tau_s, normal);
    for (Index row = 0; row < run.rows(); ++row) {
      if (run.is_reset(row) && !run.at_rest_before[static_cast<std::size_t>(row)]) state += branches_;
    }
  }
  normal.n.triangularView<Eigen::StrictlyUpper>() = normal.n.transpose();
  add_priors(normal);
  normal.n.diagonal() *= 1.0 + 1e-12;
  // Resistances are not negative: those that would be are held at zero, until no more would.
  const Index first = em_count(), last = em_count() + r_count() * (branches_ + 1);
  std::vector<bool> held(static_cast<std::size_t>(linear_count()), false);
  LinearSolution out;
  for (int pass = 0; pass < 30; ++pass) {
    std::vector<Index> free;
    for (Index k = 0; k < linear_count(); ++k) {
      if (!held[static_cast<std::size_t>(k)]) free.push_back(k);
    }
    const Eigen::VectorXd part = normal.n(free, free).ldlt().solve(normal.g(free));
    out.x = Eigen::VectorXd::Zero(linear_count());
    for (std::size_t k = 0; k < free.size(); ++k) out.x(free[k]) = part(static_cast<Index>(k));
    bool all_well = true;
    for (Index k = first; k < last; ++k) {
      if (out.x(k) < 0.0) {
        held[static_cast<std::size_t>(k)] = true;
        out.x(k) = 0.0;
        all_well = false;
      }
    }
    if (all_well) break;
  }
  out.cost = normal.yy - 2.0 * normal.g.dot(out.x) + out.x.dot(normal.n * out.x);
  return out;
}

Eigen::VectorXd CircuitFit::search_taus(const Eigen::VectorXd& start_s, int evaluations) const {
  const auto cost = [&](const Eigen::VectorXd& log_tau) {
    // Branches keep their order and a distance of 1.5; outside this and 0.2 s to the longest a wall rises.
    double wall = 0.0;
    for (Index k = 0; k < log_tau.size(); ++k) {
      const double low = k == 0 ? std::log(0.2) : log_tau(k - 1) + std::log(1.5);
      wall += std::max(0.0, low - log_tau(k)) + std::max(0.0, log_tau(k) - std::log(priors_.tau_longest_s));
    }
    const Eigen::VectorXd tau = log_tau.array().min(std::log(5e4)).max(std::log(1e-2)).exp();
    return solve(tau.transpose().replicate(r_count(), 1)).cost * (1.0 + wall);
  };
  return simplex_minimum(cost, start_s.array().log().matrix(), 0.7, evaluations).array().exp();
}

CircuitModel CircuitFit::model_of(const LinearSolution& solution, const Eigen::MatrixXd& tau_s) const {
  CircuitModel model;
  model.em = solution.x.head(em_count());
  model.r = Eigen::Map<const Eigen::MatrixXd>(solution.x.data() + em_count(), r_count(), branches_ + 1);
  model.tau = tau_s;
  return model;
}

}  // namespace voltlap::plant
