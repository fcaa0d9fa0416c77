// SPDX-License-Identifier: Apache-2.0
#include "discrepancy/usual.hpp"

#include <algorithm>
#include <cmath>

namespace voltlap::plant {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kRounds = 25, kRoundsOfMembers = 8;

/// How much the block scores of the remainder scatter beyond white noise: 80 % quantile over the columns.
double inflation_of(const std::vector<BlockSum>& blocks) {
  BlockSum all = empty_sum(blocks.front().score.size());
  for (const BlockSum& block : blocks) all.add(block);
  MatrixXd regular = all.gram;
  regular.diagonal().array() += 1.0 / 9.0;
  const VectorXd fit = regular.ldlt().solve(all.score);
  std::vector<double> ratios;
  for (Index k = 0; k < fit.size(); ++k) {
    if (all.gram(k, k) <= 0.0) continue;
    double scatter = 0.0;
    for (const BlockSum& block : blocks) {
      const double s = block.score(k) - block.gram.row(k).dot(fit);
      scatter += s * s;
    }
    ratios.push_back(scatter / all.gram(k, k));
  }
  if (ratios.empty()) return 1.0;
  std::sort(ratios.begin(), ratios.end());
  return std::max(1.0, ratios[ratios.size() * 8 / 10]);
}

/// What no log tells beforehand: what differs from day to day, and the start. Without references also what a model
/// usually misses.
VectorXd always_free(const Design& design, bool with_references) {
  constexpr double kAlone = 0.02, kShareOfUsual = 0.03, kMost = 0.4;  // so that what is found stands out of the log's own floor
  VectorXd v(static_cast<Index>(design.columns.size()));
  for (std::size_t k = 0; k < design.columns.size(); ++k) {
    const Column& column = design.columns[k];
    double size = column.cause >= 0 ? column.repeats : 0.0;
    if (!with_references) size = column.cause >= 0 ? kAlone : kShareOfUsual * std::min(kMost, column.usual);
    if (column.key.starts_with("local/")) size = 0.0;
    v(static_cast<Index>(k)) = size * size;
    if (column.key.starts_with("initial_soc/") && !design.comparison.facts.starts_at_rest) v(static_cast<Index>(k)) = 2.0;
    if (column.free > 0.0) v(static_cast<Index>(k)) = column.free * column.free;
  }
  return v;
}

/// Kelvin by which the mean temperature of this log is outside those of the references, with a margin.
double outside_k(const Design& design, const std::vector<Reference>& references) {
  constexpr double kMargin = 3.0;
  double low = 1e300, high = -1e300;
  for (const Reference& reference : references) {
    const double mean = reference.design->base.battery.temperature_c.mean();
    low = std::min(low, mean - kMargin);
    high = std::max(high, mean + kMargin);
  }
  const double here = design.base.battery.temperature_c.mean();
  return std::max({0.0, low - here, here - high});
}

/// The shapes without a name that act on a channel.
std::vector<Index> shapes_on(const Design& design, std::size_t channel) {
  std::vector<Index> out;
  for (std::size_t k = 0; k < design.columns.size(); ++k) {
    const Column& column = design.columns[k];
    if (column.cause < 0 && column.free == 0.0 && column.effect[channel].size() > 0) out.push_back(static_cast<Index>(k));
  }
  return out;
}

/// References say little about temperatures that they did not have: 10 K away they say nothing.
void widen_outside(const Design& design, const std::vector<Reference>& references, Usual& out) {
  constexpr double kForgotten = 10.0, kMost = 0.4;  // K; usual sizes of the channel
  const double share = outside_k(design, references) / kForgotten;
  for (std::size_t k = 0; k < design.columns.size(); ++k) {
    const Column& column = design.columns[k];
    if (column.cause < 0 && column.free == 0.0) out.variance(static_cast<Index>(k), static_cast<Index>(k)) += std::pow(share * std::min(kMost, column.usual), 2);
  }
}

void learn(const Design& design, const std::vector<Reference>& references, Usual& out) {
  std::vector<BlockSum> sums;
  for (const Reference& reference : references) sums.push_back(in_order_of(design, reference, out.inflation));
  for (std::size_t c = 0; c < design.comparison.channels.size(); ++c) {
    const std::vector<Index> columns = shapes_on(design, c);
    std::vector<LogSums> logs;
    for (const BlockSum& sum : sums) logs.push_back({sum.gram(columns, columns), sum.score(columns)});
    const MixedModel model = mixed_model(logs, prior_of(design, columns), kRounds);
    out.mean(columns) = model.mean;
    out.variance(columns, columns) = model.variance();
  }
  widen_outside(design, references, out);
}

/// Median and its robust spread.
std::pair<double, double> robust(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  const double median = *middle;
  for (double& v : values) v = std::abs(v - median);
  std::nth_element(values.begin(), middle, values.end());
  return {median, 1.4826 * *middle};
}

MatrixXd coefficients(const GroupScore& score) {
  MatrixXd gram = score.gram;
  gram.diagonal().array() += 1.0 / 9.0;
  return gram.ldlt().solve(score.score);
}

/// Sums of the same group in the references that have the same members.
std::vector<const GroupScore*> same_group(const Design& design, std::size_t g, Index shapes,
                                          const std::vector<Reference>& references) {
  std::vector<const GroupScore*> out;
  for (const Reference& reference : references) {
    const auto& groups = reference.design->comparison.groups;
    for (std::size_t r = 0; r < groups.size(); ++r) {
      const GroupScore& theirs = reference.score.groups[r];
      if (groups[r].members == design.comparison.groups[g].members && theirs.gram.rows() == shapes) out.push_back(&theirs);
    }
  }
  return out;
}

/// From one log alone: nothing is known of a member, and the members differ as robustly as they do here.
void members_of_one_log(const GroupScore& score, bool thermal, Usual& out) {
  const double least = thermal ? 0.2 : 0.02;
  const MatrixXd own = coefficients(score);
  VectorXd variance(own.rows());
  for (Index k = 0; k < own.rows(); ++k) {
    const VectorXd row = own.row(k);
    const double spread = std::max(least, robust({row.begin(), row.end()}).second);
    variance(k) = spread * spread;
  }
  out.group_mean.push_back(MatrixXd::Zero(own.rows(), own.cols()));
  out.group_variance.emplace_back(variance.asDiagonal());
  out.group_inflation.push_back(1.0);
}

/// By shape: mean square of what each log shows when the others judge it, over what they let expect.
VectorXd surprise_of(const std::vector<LogSums>& logs, const ColumnPrior& prior) {
  VectorXd out = VectorXd::Zero(prior.usual.size());
  for (std::size_t k = 0; logs.size() > 1 && k < logs.size(); ++k) {
    std::vector<LogSums> others = logs;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(k));
    const MixedModel model = mixed_model(others, prior, kRoundsOfMembers);
    const VectorXd rest = logs[k].score - logs[k].gram * model.mean;
    const VectorXd expected = (logs[k].gram + logs[k].gram * model.variance() * logs[k].gram).diagonal();
    out += (rest.cwiseAbs2().cwiseQuotient(expected.cwiseMax(1e-300))) / static_cast<double>(logs.size());
  }
  return out;
}

/// From references: each member as it is known to be, and what all of them change from log to log.
void members_of_references(const std::vector<const GroupScore*>& references,
                           const std::vector<Shape>& shapes_of_group, Usual& out) {
  const Index shapes = references[0]->score.rows(), members = references[0]->score.cols();
  ColumnPrior prior;
  for (Index k = 0; k < shapes; ++k) prior.kin.push_back(static_cast<std::size_t>(k));
  prior.usual.resize(shapes);
  prior.repeats.resize(shapes);
  constexpr double kLeast = 1e-4;  // typical sizes
  for (Index k = 0; k < shapes; ++k) {
    prior.usual(k) = std::max(kLeast, shapes_of_group[static_cast<std::size_t>(k)].spread);
    prior.repeats(k) = std::max(kLeast, shapes_of_group[static_cast<std::size_t>(k)].repeats);
  }
  prior.columns = 4.0;
  MatrixXd mean(shapes, members), variance = MatrixXd::Zero(shapes, shapes);
  VectorXd surprise = VectorXd::Zero(shapes);
  const Index every = std::max<Index>(1, members / 4);  // some stand for all
  for (Index i = 0; i < members; ++i) {
    std::vector<LogSums> logs;
    for (const GroupScore* reference : references) logs.push_back({reference->gram, reference->score.col(i)});
    if (i % every == 0) surprise += surprise_of(logs, prior) / std::ceil(static_cast<double>(members) / static_cast<double>(every));
    const MixedModel model = mixed_model(logs, prior, kRoundsOfMembers);
    mean.col(i) = model.mean;
    variance += model.mean_covariance / static_cast<double>(members);
    variance.diagonal() += model.between / static_cast<double>(members);
  }
  out.group_mean.push_back(mean);
  out.group_variance.push_back(variance);
  out.group_inflation.push_back(std::max(1.0, surprise.maxCoeff()));
}

void learn_groups(const Design& design, const Score& score, const std::vector<Reference>& references, Usual& out) {
  for (std::size_t g = 0; g < score.groups.size(); ++g) {
    const auto theirs = same_group(design, g, score.groups[g].score.rows(), references);
    if (theirs.empty()) {
      members_of_one_log(score.groups[g], design.comparison.groups[g].balance == Balance::kHeat, out);
    } else {
      members_of_references(theirs, design.shapes[g], out);
    }
  }
}

/// Without what sound logs show of the causes.
Usual unseen(const Design& design, const Score& score, const std::vector<Reference>& references,
             const std::vector<double>& inflation) {
  Usual out;
  const auto p = static_cast<Index>(design.columns.size());
  out.references = references.size();
  out.mean = VectorXd::Zero(p);
  out.variance = MatrixXd::Zero(p, p);
  for (std::size_t c = 0; c < score.channels.size(); ++c) {
    const double given = inflation.empty() ? 1.0 : inflation[c];
    out.inflation.push_back(references.empty() ? inflation_of(score.channels[c]) : given);
  }
  if (!references.empty()) learn(design, references, out);
  out.variance.diagonal() += always_free(design, !references.empty());
  learn_groups(design, score, references, out);
  return out;
}

/// What sound logs show of each cause, each judged by the others, is what differs from log to log: its variance.
VectorXd seen_of_causes(const Design& design, const std::vector<Remaining>& sound) {
  constexpr double kLeast = 2e-3, kWeight = 1.0, kStart = 50.0;  // typical sizes; logs; of the least
  std::vector<Index> columns;
  for (std::size_t k = 0; k < design.columns.size(); ++k) {
    if (design.columns[k].cause >= 0 && !design.columns[k].key.starts_with("local/")) columns.push_back(static_cast<Index>(k));
  }
  ColumnPrior prior = prior_of(design, columns);
  for (std::size_t k = 0; k < columns.size(); ++k) prior.kin[k] = k;
  prior.usual.setConstant(1e-6);
  prior.repeats.setConstant(kLeast);
  prior.columns = kWeight;
  prior.start = kStart;
  std::vector<LogSums> logs;
  for (const Remaining& log : sound) logs.push_back({log.information(columns, columns), log.score(columns)});
  VectorXd out = VectorXd::Zero(static_cast<Index>(design.columns.size()));
  out(columns) = mixed_model(logs, prior, kRounds).between;
  return out;
}

}  // namespace

BlockSum in_order_of(const Design& design, const Reference& reference, const std::vector<double>& inflation) {
  const BlockSum own = reference.score.sum(inflation);
  const auto p = static_cast<Index>(design.columns.size());
  std::vector<Index> from(design.columns.size(), -1);
  for (std::size_t k = 0; k < design.columns.size(); ++k) {
    const auto& theirs = reference.design->columns;
    const auto found = std::find_if(theirs.begin(), theirs.end(),
                                    [&](const Column& c) { return c.key == design.columns[k].key; });
    if (found != theirs.end()) from[k] = static_cast<Index>(found - theirs.begin());
  }
  BlockSum out = empty_sum(p);
  out.rows = own.rows;
  out.energy = own.energy;
  for (Index a = 0; a < p; ++a) {
    const Index fa = from[static_cast<std::size_t>(a)];
    if (fa < 0) continue;
    out.score(a) = own.score(fa);
    for (Index b = 0; b < p; ++b) {
      const Index fb = from[static_cast<std::size_t>(b)];
      if (fb >= 0) out.gram(a, b) = own.gram(fa, fb);
    }
  }
  return out;
}

std::vector<Remaining> references_by_the_others(const Design& design, const Score& score,
                                                const std::vector<Reference>& references,
                                                const std::vector<double>& inflation) {
  std::vector<Remaining> out;
  for (std::size_t k = 0; references.size() > 1 && k < references.size(); ++k) {
    std::vector<Reference> others = references;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(k));
    const Usual usual = unseen(design, score, others, inflation);
    out.push_back(remaining(in_order_of(design, references[k], usual.inflation), usual));
  }
  return out;
}

Usual usual_discrepancy(const Design& design, const Score& score, const std::vector<Reference>& references,
                        const std::vector<double>& inflation) {
  Usual out = unseen(design, score, references, inflation);
  out.seen = VectorXd::Zero(static_cast<Index>(design.columns.size()));
  if (references.size() > 1) out.seen = seen_of_causes(design, references_by_the_others(design, score, references, out.inflation));
  out.variance.diagonal() += out.seen;
  return out;
}

Usual group_spread(const Design& design, const Score& score, const std::vector<Reference>& references) {
  Usual out;
  learn_groups(design, score, references, out);
  return out;
}

Remaining remaining(const BlockSum& sum, const Usual& usual) {
  const Index p = sum.score.size();
  const auto lu = (MatrixXd::Identity(p, p) + sum.gram * usual.variance).partialPivLu();
  Remaining out{lu.solve(sum.gram), lu.solve(sum.score - sum.gram * usual.mean)};
  out.information = 0.5 * (out.information + out.information.transpose()).eval();
  return out;
}

}  // namespace voltlap::plant
