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
  const Whitener whitener(design.comparison.log.time_s, finite_rows(residual), noise, ohm_of(design, channel));
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
  const Whitener whitener(time, valid, noise, VectorXd());
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

/// Residual minus these amounts of the columns.
VectorXd remainder(const Design& design, std::size_t channel, const std::vector<Index>& columns,
                   const VectorXd& coefficients) {
  VectorXd out = design.residual[channel];
  for (std::size_t k = 0; k < columns.size(); ++k) {
    out -= coefficients(static_cast<Index>(k)) * design.columns[static_cast<std::size_t>(columns[k])].effect[channel];
  }
  return out;
}

/// Columns that act on a channel: all, or the shapes without a name alone.
std::vector<Index> columns_on(const Design& design, std::size_t channel, bool anonymous_only) {
  std::vector<Index> out;
  for (std::size_t k = 0; k < design.columns.size(); ++k) {
    const Column& column = design.columns[k];
    const bool shape = column.cause < 0 && column.free == 0.0;
    if (column.effect[channel].size() > 0 && (shape || !anonymous_only)) out.push_back(static_cast<Index>(k));
  }
  return out;
}

LogSums sums_of(const std::vector<BlockSum>& blocks, const std::vector<Index>& columns) {
  const auto n = static_cast<Index>(columns.size());
  LogSums out{MatrixXd::Zero(n, n), VectorXd::Zero(n)};
  for (const BlockSum& block : blocks) {
    out.gram += block.gram(columns, columns);
    out.score += block.score(columns);
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
Noise with_lost_part(Noise noise, double seconds, double slow_columns, double most) {
  noise.coloured *= std::sqrt(std::min(most, 1.0 + slow_columns * 2.0 * noise.tau_s / seconds));
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

std::size_t channel_named(const Design& design, const std::string& name) {
  const auto& all = design.comparison.channels;
  return static_cast<std::size_t>(
      std::find_if(all.begin(), all.end(), [&](const BalanceChannel& c) { return c.name == name; }) - all.begin());
}

/// What is left in a channel of these logs when what they have in common and each one's own are taken away.
std::vector<NoiseSample> remainders(const std::vector<const Design*>& designs, const std::string& name,
                                    const Noise& noise) {
  constexpr int kRounds = 6;
  const bool alone = designs.size() == 1;
  std::vector<LogSums> logs;
  std::vector<std::vector<Index>> columns;
  for (const Design* design : designs) {
    const std::size_t c = channel_named(*design, name);
    columns.push_back(columns_on(*design, c, !alone));
    logs.push_back(sums_of(channel_sums(*design, c, noise, block_of_rows(design->comparison.log.time_s)), columns.back()));
  }
  std::vector<VectorXd> amounts;
  const bool same = std::all_of(columns.begin(), columns.end(), [&](const auto& c) { return c.size() == columns[0].size(); });
  if (alone || !same) {
    for (std::size_t k = 0; k < logs.size(); ++k) {
      for (std::size_t i = 0; i < columns[k].size(); ++i) {
        const Column& column = designs[k]->columns[static_cast<std::size_t>(columns[k][i])];
        const double size = column.cause >= 0 ? 1.0 : 2.0 * column.usual;
        logs[k].gram(static_cast<Index>(i), static_cast<Index>(i)) += 1.0 / (size * size);
      }
      amounts.push_back(logs[k].gram.ldlt().solve(logs[k].score));
    }
  } else {
    ColumnPrior prior = prior_of(*designs[0], columns[0]);
    prior.repeats = 0.03 * prior.usual;
    prior.start = 30.0;  // what shapes can explain is no noise
    amounts = mixed_model(logs, prior, kRounds).own;
  }
  std::vector<NoiseSample> out;
  for (std::size_t k = 0; k < designs.size(); ++k) {
    const std::size_t c = channel_named(*designs[k], name);
    out.push_back({&designs[k]->comparison.log.time_s, remainder(*designs[k], c, columns[k], amounts[k]),
                   ohm_of(*designs[k], c)});
  }
  return out;
}

Noise channel_noise(const std::vector<const Design*>& designs, const std::string& name, double longest_s) {
  const Design& first = *designs[0];
  const BalanceChannel& channel = first.comparison.channels[channel_named(first, name)];
  const double usual = usual_size(channel, first.model.car.battery.cells_in_series), least = least_noise(usual);
  std::vector<NoiseSample> samples;
  for (const Design* design : designs) {
    const std::size_t c = channel_named(*design, name);
    samples.push_back({&design->comparison.log.time_s, design->residual[c], ohm_of(*design, c)});
  }
  // One log alone does not tell what is slow in it from what its model misses; an error of the charge is one constant a
  // log, of which its noise tells nothing: where too little is known the grid's answer, which allows for more, stays.
  const bool told = designs.size() > 1 && channel.balance != Balance::kCharge;
  const NoiseSearch search = told ? NoiseSearch::kBetween : NoiseSearch::kGrid;
  // What is slow is left to the shapes at first: an error of the model that once counts as noise would stay noise.
  constexpr double kFast = 20.0;  // s
  Noise noise = fit_noise(samples, least, search, told ? std::min(kFast, longest_s) : longest_s);
  for (int pass = 0; pass < 2; ++pass) noise = fit_noise(remainders(designs, name, noise), least, search, longest_s);
  const VectorXd& time = first.comparison.log.time_s;
  const double seconds = time(time.size() - 1) - time(0);
  constexpr double kOfOneLog = 20.0, kMostOfOneLog = 4.0, kOfMany = 5.0, kMostOfMany = 2.0;
  if (designs.size() > 1) {
    noise = with_lost_part(noise, seconds, kOfMany, kMostOfMany);
    return channel.name == "soc" ? with_model_error(noise, usual) : noise;
  }
  return with_model_error(with_lost_part(noise, seconds, kOfOneLog, kMostOfOneLog), usual);
}

Noise group_noise(const std::vector<const Design*>& designs, const std::string& stem) {
  std::vector<NoiseSample> raw, samples;
  double least = 0.0;
  const auto each = [&](const auto& use) {
    for (const Design* design : designs) {
      for (std::size_t g = 0; g < design->comparison.groups.size(); ++g) {
        if (design->comparison.groups[g].stem == stem) use(*design, g);
      }
    }
  };
  each([&](const Design& design, std::size_t g) {
    const Group& group = design.comparison.groups[g];
    least = least_noise(group.balance == Balance::kHeat ? 1.0 : 5e-3);
    for (const VectorXd& deviation : {group.deviation.front(), group.deviation.back()}) {
      raw.push_back({&design.comparison.log.time_s, deviation, VectorXd()});
    }
  });
  const Noise noise = fit_noise(raw, least, NoiseSearch::kBetween);
  each([&](const Design& design, std::size_t g) {
    for (VectorXd& rest : group_remainders(design, g, group_score(design, g, noise))) {
      samples.push_back({&design.comparison.log.time_s, std::move(rest), VectorXd()});
    }
  });
  return fit_noise(samples, least, NoiseSearch::kBetween);
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

std::vector<BlockSum> channel_totals(const Score& score) {
  std::vector<BlockSum> out;
  for (const auto& blocks : score.channels) {
    out.push_back(empty_sum(score.columns()));
    for (const BlockSum& block : blocks) out.back().add(block);
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

VectorXd ohm_of(const Design& design, std::size_t channel) {
  if (channel > 0) return {};
  const BatterySection& battery = design.model.car.battery;
  const double cells = design.comparison.channels[0].name == "voltage" ? 1.0 : battery.cells_in_series;
  VectorXd out = design.base.battery.r0_ohm * (cells / battery.cells_in_parallel);
  const std::vector<bool>& averaged = design.comparison.facts.at_rest;
  for (Index row = 0; row < out.size(); ++row) {
    if (averaged[static_cast<std::size_t>(row)]) out(row) = 0.0;
  }
  return out;
}

ColumnPrior prior_of(const Design& design, const std::vector<Index>& columns) {
  ColumnPrior out;
  out.usual.resize(static_cast<Index>(columns.size()));
  out.repeats.resize(static_cast<Index>(columns.size()));
  for (std::size_t k = 0; k < columns.size(); ++k) {
    const Column& column = design.columns[static_cast<std::size_t>(columns[k])];
    out.kin.push_back(k);  // each column by itself: what one repeats tells little of the others
    out.usual(static_cast<Index>(k)) = column.usual;
    out.repeats(static_cast<Index>(k)) = column.repeats;
  }
  return out;
}

NoiseModel noise_of(const std::vector<const Design*>& designs) {
  constexpr double kSlower = 2.0;  // as well as a time is known
  NoiseModel out;
  for (const Design* design : designs) {
    for (const Group& group : design->comparison.groups) {
      if (out.count(group.stem) == 0) out[group.stem] = group_noise(designs, group.stem);
    }
  }
  for (const Design* design : designs) {
    for (const BalanceChannel& channel : design->comparison.channels) {
      if (out.count(channel.name) > 0) continue;
      std::vector<const Design*> with;
      for (const Design* other : designs) {
        if (other->comparison.find(channel.name) != nullptr) with.push_back(other);
      }
      // Sensors of one kind wander alike: their mean no slower than each against it.
      const auto each = out.find((channel.balance == Balance::kVoltage ? "cell_" : "") + channel.name + "_");
      const bool known = each != out.end() && designs.size() > 1;
      out[channel.name] = channel_noise(with, channel.name, known ? kSlower * each->second.tau_s : kLongestMemory);
    }
  }
  return out;
}

}  // namespace voltlap::plant
