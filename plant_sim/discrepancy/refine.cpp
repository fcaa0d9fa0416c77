// SPDX-License-Identifier: Apache-2.0
#include "discrepancy/refine.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "discrepancy/curved_member.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kRounds = 4;
constexpr double kStep = 0.05;        // of a typical size
constexpr double kPriorVariance = 9.0;

/// A free parameter of the set.
struct Free {
  std::size_t cause, parameter;  ///< of the set, of the cause
  bool logarithmic;              ///< a time constant
  const CauseParameter* prior;
};

World world_of(const World& model, const Design& design, const System& system, const RefinedSet& set) {
  World world = model;
  for (const RefinedCause& cause : set.causes) {
    const Candidate& c = system.candidates[cause.candidate];
    if (c.cause < 0) continue;
    const Form& form = design.forms[static_cast<std::size_t>(c.cause)][c.form];
    if (form.apply) form.apply(world, cause.values);
  }
  return world;
}

}  // namespace

Refinery::Refinery(const Design& design, const std::vector<Cause>& causes, const System& system,
                   const NoiseModel& noise, const Usual& usual, const std::vector<bool>& use_rows)
    : design_(design), causes_(causes), system_(system), noise_(noise), usual_(usual) {
  const VectorXd& time = design.comparison.log.time_s;
  const Index n = time.size();
  const auto p = static_cast<Index>(design.columns.size());
  const auto channels = static_cast<Index>(design.residual.size());
  stacked_ = MatrixXd::Zero(n * channels, p);
  for (Index c = 0; c < channels; ++c) {
    const auto at = static_cast<std::size_t>(c);
    std::vector<bool> valid = finite_rows(design.residual[at]);
    for (std::size_t row = 0; row < valid.size(); ++row) valid[row] = valid[row] && (use_rows.empty() || use_rows[row]);
    whiteners_.emplace_back(time, valid, noise.at(design.comparison.channels[at].name), ohm_of(design, at));
    weight_.push_back(1.0 / std::sqrt(usual.inflation[at]));
    for (Index k = 0; k < p; ++k) {
      const VectorXd& effect = design.columns[static_cast<std::size_t>(k)].effect[at];
      if (effect.size() > 0) stacked_.col(k).segment(c * n, n) = whiteners_[at].apply(effect) * weight_[at];
    }
  }
  discount_.emplace(stacked_.transpose() * stacked_, usual.variance);
  mean_effect_ = stacked_ * usual.mean;
}

std::vector<VectorXd> Refinery::whitened(const std::vector<VectorXd>& channels) const {
  std::vector<VectorXd> out;
  for (std::size_t c = 0; c < channels.size(); ++c) out.push_back(whiteners_[c].apply(channels[c]) * weight_[c]);
  return out;
}

Refinery::Normal Refinery::normal_of(const std::vector<std::vector<VectorXd>>& jacobian,
                                     const std::vector<VectorXd>& residual) const {
  const Index n = design_.comparison.log.rows();
  const auto stack = [&](const std::vector<VectorXd>& channels) {
    VectorXd out(n * static_cast<Index>(channels.size()));
    for (std::size_t c = 0; c < channels.size(); ++c) out.segment(static_cast<Index>(c) * n, n) = channels[c];
    return out;
  };
  const VectorXd r = stack(residual) - mean_effect_;
  MatrixXd j(r.size(), static_cast<Index>(jacobian.size()));
  for (std::size_t k = 0; k < jacobian.size(); ++k) j.col(static_cast<Index>(k)) = stack(jacobian[k]);
  const MatrixXd of_j = discount_->whitened(stacked_.transpose() * j);
  const VectorXd of_r = discount_->whitened(stacked_.transpose() * r).col(0);
  return {j.transpose() * j - of_j.transpose() * of_j, j.transpose() * r - of_j.transpose() * of_r,
          r.squaredNorm() - of_r.squaredNorm()};
}

RefinedSet Refinery::refine(const std::vector<std::size_t>& members) const {
  RefinedSet set;
  std::vector<Free> free;
  const SetFit linear = fit_set(system_, members);
  Index at = 0;
  std::vector<VectorXd> local_effect;
  for (std::size_t m = 0; m < members.size(); ++m) {
    const Candidate& c = system_.candidates[members[m]];
    RefinedCause refined{members[m], {}, {}, 0.0, true};
    const auto columns = static_cast<Index>(c.rows.size());
    const VectorXd own = linear.coefficients.segment(at, columns);
    refined.distance = std::sqrt(std::max(
        0.0, own.dot(linear.covariance.block(at, at, columns, columns).ldlt().solve(own))));
    if (c.cause >= 0) {
      const Cause& cause = causes_[static_cast<std::size_t>(c.cause)];
      const Form& form = design_.forms[static_cast<std::size_t>(c.cause)][c.form];
      refined.values = form.at;
      refined.sigma.assign(form.at.size(), 0.0);
      for (Index k = 0; k < columns; ++k) {
        const std::size_t parameter = c.parameters[static_cast<std::size_t>(k)];
        const CauseParameter& p = cause.parameters[parameter];
        refined.values[parameter] += own(k) * p.typical;
        refined.sigma[parameter] = std::sqrt(linear.covariance(at + k, at + k)) * p.typical;
        if (form.apply) refined.values[parameter] = std::clamp(refined.values[parameter], p.low, p.high);
      }
      if (form.curved) {
        const CurvedValues bent = curved_values(design_, noise_, usual_, cause, c, own);
        const MatrixXd spread = linear.covariance.block(at, at, columns, columns);
        const MatrixXd covariance = bent.per_size * spread * bent.per_size.transpose();
        for (Index k = 0; k < columns; ++k) {
          const std::size_t parameter = c.parameters[static_cast<std::size_t>(k)];
          refined.values[parameter] = form.at[parameter] + bent.values(k);
          refined.sigma[parameter] = std::sqrt(covariance(k, k));
        }
        refined.inside_prior = bent.inside_prior;
      }
      if (form.apply) {
        for (const std::size_t parameter : form.refined) {
          const CauseParameter& p = cause.parameters[parameter];
          free.push_back({m, parameter, std::string_view(p.name) == "tau_s", &p});
        }
      }
    }
    at += columns;
    set.causes.push_back(std::move(refined));
  }
  set.gain = linear.gain;
  set.world = world_of(design_.model, design_, system_, set);
  const bool all_global = std::all_of(members.begin(), members.end(), [&](std::size_t m) {
    return system_.candidates[m].cause >= 0 && system_.candidates[m].group < 0;
  });
  if (!all_global) return set;
  const auto residual_at = [&](const RefinedSet& tried) {
    return residuals_of(design_.comparison, predict(world_of(design_.model, design_, system_, tried), design_.comparison));
  };
  const auto value = [&](RefinedSet& of, const Free& f) -> double& { return of.causes[f.cause].values[f.parameter]; };
  const double start = normal_of({}, whitened(design_.residual)).energy;
  double energy = 1e300;
  RefinedSet best = set;
  for (int round = 0; round < kRounds; ++round) {
    const std::vector<VectorXd> residual = whitened(residual_at(set));
    std::vector<std::vector<VectorXd>> jacobian;
    for (const Free& f : free) {
      RefinedSet moved = set;
      const double step = f.logarithmic ? 0.05 : kStep * f.prior->typical;
      value(moved, f) = f.logarithmic ? value(set, f) * std::exp(step) : value(set, f) + step;
      std::vector<VectorXd> column = whitened(residual_at(moved));
      const double scale = f.logarithmic ? 1.0 / step : f.prior->typical / step;
      for (std::size_t c = 0; c < column.size(); ++c) column[c] = (residual[c] - column[c]) * scale;
      jacobian.push_back(std::move(column));
    }
    Normal normal = normal_of(jacobian, residual);
    const double before = energy;
    if (normal.energy < energy) {
      energy = normal.energy;
      best = set;
      best.gain = start - energy;
    }
    for (std::size_t k = 0; k < free.size(); ++k) {
      const auto i = static_cast<Index>(k);
      const double prior = free[k].logarithmic ? 1.0 : kPriorVariance;
      normal.information(i, i) += 1.0 / prior;
      if (!free[k].logarithmic) normal.score(i) -= value(set, free[k]) / free[k].prior->typical / prior;
    }
    const auto factor = normal.information.ldlt();
    const VectorXd step = factor.solve(normal.score);
    const MatrixXd covariance = factor.solve(MatrixXd::Identity(step.size(), step.size()));
    if (normal.energy <= energy) {
      for (std::size_t k = 0; k < free.size(); ++k) {
        const double sigma = std::sqrt(covariance(static_cast<Index>(k), static_cast<Index>(k)));
        best.causes[free[k].cause].sigma[free[k].parameter] =
            free[k].logarithmic ? sigma * value(best, free[k]) : sigma * free[k].prior->typical;
      }
    }
    if (round > 0 && before - normal.energy < 0.05) break;
    for (std::size_t k = 0; k < free.size(); ++k) {
      const double by = step(static_cast<Index>(k));
      double& v = value(set, free[k]);
      v = free[k].logarithmic ? v * std::exp(std::clamp(by, -0.7, 0.7)) : v + by * free[k].prior->typical;
      v = std::clamp(v, free[k].prior->low, free[k].prior->high);
    }
  }
  for (const Free& f : free) {
    if (!is_inside_prior(*f.prior, value(best, f))) best.causes[f.cause].inside_prior = false;
  }
  best.world = world_of(design_.model, design_, system_, best);
  return best;
}

}  // namespace voltlap::plant
