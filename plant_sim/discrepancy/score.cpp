// SPDX-License-Identifier: Apache-2.0
#include "discrepancy/score.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "discrepancy/anonymous_shapes.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kPriorVariance = 9.0;  // of a coefficient, in typical sizes squared

std::vector<BlockSum> channel_sums(const Design& design, std::size_t channel, const Noise& noise,
                                   const std::vector<std::size_t>& block) {
  const VectorXd& residual = design.residual[channel];
  const Whitener whitener(design.comparison.log.time_s, finite_rows(residual), noise);
  const VectorXd y = whitener.apply(residual);
  const auto p = static_cast<Index>(design.columns.size());
  std::vector<Index> active;
  for (Index k = 0; k < p; ++k) {
    if (design.columns[static_cast<std::size_t>(k)].effect[channel].size() > 0) active.push_back(k);
  }
  const auto q = static_cast<Index>(active.size());
  MatrixXd x(residual.size(), q);
  for (Index k = 0; k < q; ++k) {
    x.col(k) = whitener.apply(design.columns[static_cast<std::size_t>(active[static_cast<std::size_t>(k)])].effect[channel]);
  }
  std::vector<BlockSum> out;
  for (Index first = 0; first < y.size();) {
    Index last = first;
    while (last < y.size() && block[static_cast<std::size_t>(last)] == block[static_cast<std::size_t>(first)]) ++last;
    while (out.size() < block[static_cast<std::size_t>(first)]) out.push_back(empty_sum(p));
    const auto rows = x.middleRows(first, last - first);
    const auto part = y.segment(first, last - first);
    const MatrixXd gram = rows.transpose() * rows;
    const VectorXd score = rows.transpose() * part;
    BlockSum sum = empty_sum(p);
    sum.energy = part.squaredNorm();
    for (Index row = first; row < last; ++row) sum.rows += std::isfinite(residual(row)) ? 1.0 : 0.0;
    for (Index a = 0; a < q; ++a) {
      const Index ia = active[static_cast<std::size_t>(a)];
      sum.score(ia) = score(a);
      for (Index b = 0; b < q; ++b) sum.gram(ia, active[static_cast<std::size_t>(b)]) = gram(a, b);
    }
    out.push_back(std::move(sum));
    first = last;
  }
  return out;
}

GroupScore group_score(const Design& design, std::size_t g, const Noise& noise) {
  const Group& group = design.comparison.groups[g];
  const VectorXd& time = design.comparison.log.time_s;
  std::vector<bool> valid(static_cast<std::size_t>(time.size()), true);
  for (const VectorXd& deviation : group.deviation) {
    for (Index row = 0; row < time.size(); ++row) {
      if (!std::isfinite(deviation(row))) valid[static_cast<std::size_t>(row)] = false;
    }
  }
  const Whitener whitener(time, valid, noise);
  const auto m = static_cast<Index>(design.shapes[g].size()), n = static_cast<Index>(group.members.size());
  MatrixXd x(time.size(), m);
  for (Index k = 0; k < m; ++k) x.col(k) = whitener.apply(design.shapes[g][static_cast<std::size_t>(k)].effect);
  GroupScore out{x.transpose() * x, MatrixXd(m, n), VectorXd(n), 0.0};
  out.rows = static_cast<double>(std::count(valid.begin(), valid.end(), true));
  for (Index i = 0; i < n; ++i) {
    const VectorXd y = whitener.apply(group.deviation[static_cast<std::size_t>(i)]);
    out.score.col(i) = x.transpose() * y;
    out.energy(i) = y.squaredNorm();
  }
  return out;
}

/// Residual minus what the columns explain of it.
VectorXd remainder(const Design& design, std::size_t channel, const std::vector<BlockSum>& sums) {
  VectorXd out = design.residual[channel];
  BlockSum fit = empty_sum(sums.front().score.size());
  for (const BlockSum& sum : sums) fit.add(sum);
  fit.gram.diagonal().array() += 1.0 / kPriorVariance;
  const VectorXd coefficients = fit.gram.ldlt().solve(fit.score);
  for (std::size_t k = 0; k < design.columns.size(); ++k) {
    const VectorXd& effect = design.columns[k].effect[channel];
    if (effect.size() > 0) out -= coefficients(static_cast<Index>(k)) * effect;
  }
  return out;
}

/// Steps, noise of the current and what the plant does within a row leave a slow error of this share of a usual effect.
Noise with_model_error(Noise noise, double usual) {
  constexpr double kShare = 0.05, kSlow = 100.0;
  if (noise.coloured < kShare * usual) noise.tau_s = kSlow;
  noise.coloured = std::hypot(noise.coloured, kShare * usual);
  return noise;
}

/// The columns took a part of the slow noise with them: as many of its independent stretches as there are slow columns.
Noise with_lost_part(Noise noise, double seconds) {
  constexpr double kSlowColumns = 20.0, kMost = 4.0;
  noise.coloured *= std::sqrt(std::min(kMost, 1.0 + kSlowColumns * 2.0 * noise.tau_s / seconds));
  return noise;
}

std::vector<VectorXd> group_remainders(const Design& design, std::size_t g, const GroupScore& score) {
  MatrixXd gram = score.gram;
  gram.diagonal().array() += 1.0 / kPriorVariance;
  const MatrixXd coefficients = gram.ldlt().solve(score.score);
  constexpr Index kSome = 6;  // members that stand for all
  std::vector<VectorXd> out;
  const auto n = static_cast<Index>(design.comparison.groups[g].members.size());
  for (Index i = 0; i < n; i += std::max<Index>(1, n / kSome)) {
    VectorXd rest = design.comparison.groups[g].deviation[static_cast<std::size_t>(i)];
    for (std::size_t k = 0; k < design.shapes[g].size(); ++k) {
      rest -= coefficients(static_cast<Index>(k), i) * design.shapes[g][k].effect;
    }
    out.push_back(std::move(rest));
  }
  return out;
}

/// A residual's noise is never believed to be below this share of a usual effect.
double least_noise(double usual) { return 0.02 * usual; }

/// Logarithmic mean over logs: one of them does not decide.
Noise pooled(const std::vector<Noise>& all) {
  Noise out{0.0, 0.0, 0.0};
  for (const Noise& n : all) {
    out.white += n.white * n.white;
    out.coloured += n.coloured * n.coloured;
    out.tau_s += std::log(n.tau_s);
  }
  const auto count = static_cast<double>(all.size());
  return {std::sqrt(out.white / count), std::sqrt(out.coloured / count), std::exp(out.tau_s / count)};
}

}  // namespace

void BlockSum::add(const BlockSum& other, double weight) {
  gram += weight * other.gram;
  score += weight * other.score;
  energy += weight * other.energy;
  rows += other.rows;
}

BlockSum empty_sum(Index columns) { return {MatrixXd::Zero(columns, columns), VectorXd::Zero(columns), 0.0, 0.0}; }

BlockSum Score::sum(const std::vector<double>& inflation, const std::vector<bool>& use) const {
  BlockSum out = empty_sum(columns());
  for (std::size_t c = 0; c < channels.size(); ++c) {
    for (std::size_t b = 0; b < channels[c].size(); ++b) {
      if (use.empty() || use[b]) out.add(channels[c][b], inflation.empty() ? 1.0 : 1.0 / inflation[c]);
    }
  }
  return out;
}

std::vector<std::size_t> block_of_rows(const VectorXd& time_s) {
  std::vector<std::size_t> out;
  for (const double t : time_s) out.push_back(static_cast<std::size_t>((t - time_s(0)) / kBlock));
  return out;
}

Score score_of(const Design& design, const NoiseModel& noise) {
  Score out;
  const auto block = block_of_rows(design.comparison.log.time_s);
  for (std::size_t c = 0; c < design.residual.size(); ++c) {
    out.channels.push_back(channel_sums(design, c, noise.at(design.comparison.channels[c].name), block));
  }
  for (std::size_t g = 0; g < design.comparison.groups.size(); ++g) {
    out.groups.push_back(group_score(design, g, noise.at(design.comparison.groups[g].stem)));
  }
  return out;
}

NoiseModel noise_of(const std::vector<const Design*>& designs) {
  std::map<std::string, std::vector<Noise>> found;
  for (const Design* design : designs) {
    const VectorXd& time = design->comparison.log.time_s;
    const auto block = block_of_rows(time);
    for (std::size_t c = 0; c < design->residual.size(); ++c) {
      const BalanceChannel& channel = design->comparison.channels[c];
      const double least = least_noise(usual_size(channel, design->model.car.battery.cells_in_series));
      Noise noise = fit_noise(time, {design->residual[c]}, least);
      for (int pass = 0; pass < 2; ++pass) {
        noise = fit_noise(time, {remainder(*design, c, channel_sums(*design, c, noise, block))}, least);
      }
      noise = with_lost_part(noise, time(time.size() - 1) - time(0));
      noise = with_model_error(noise, usual_size(channel, design->model.car.battery.cells_in_series));
      found[channel.name].push_back(noise);
    }
    for (std::size_t g = 0; g < design->comparison.groups.size(); ++g) {
      const Group& group = design->comparison.groups[g];
      const double least = least_noise(group.balance == Balance::kHeat ? 1.0 : 5e-3);
      Noise noise = fit_noise(time, {group.deviation.front(), group.deviation.back()}, least);
      noise = fit_noise(time, group_remainders(*design, g, group_score(*design, g, noise)), least);
      found[group.stem].push_back(noise);
    }
  }
  NoiseModel out;
  for (const auto& [name, all] : found) out[name] = pooled(all);
  return out;
}

}  // namespace voltlap::plant
