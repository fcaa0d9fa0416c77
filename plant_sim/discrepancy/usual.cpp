// SPDX-License-Identifier: Apache-2.0
#include "discrepancy/usual.hpp"

#include <algorithm>
#include <cmath>

#include "discrepancy/anonymous_shapes.hpp"
#include "discrepancy/discount.hpp"
#include "discrepancy/gain.hpp"
#include "discrepancy/projections.hpp"

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
  // So that what is found stands out of the log's own floor.
  constexpr double kAlone = 0.02, kShareOfUsual = 0.03, kMost = 0.4;
  VectorXd v(static_cast<Index>(design.columns.size()));
  for (std::size_t k = 0; k < design.columns.size(); ++k) {
    const Column& column = design.columns[k];
    double size = column.cause >= 0 ? column.repeats : 0.0;
    if (!with_references) size = column.cause >= 0 ? kAlone : kShareOfUsual * std::min(kMost, column.usual);
    if (column.key.starts_with("local/")) size = 0.0;
    v(static_cast<Index>(k)) = size * size;
    const bool starts_loaded = !design.comparison.facts.starts_at_rest;
    if (column.key.starts_with("initial_soc/") && starts_loaded) v(static_cast<Index>(k)) = 2.0;
    if (column.free > 0.0) v(static_cast<Index>(k)) = column.free * column.free;
  }
  return v;
}

/// Kelvin by which the mean temperature of this log is outside those of the references, with a margin.
double outside_k(const Design& design, const std::vector<const Design*>& references) {
  constexpr double kMargin = 3.0;
  double low = 1e300, high = -1e300;
  for (const Design* reference : references) {
    const double mean = reference->base.battery.temperature_c.mean();
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
    const bool shape = column.cause < 0 && column.free == 0.0;
    if (shape && column.effect[channel].size() > 0) out.push_back(static_cast<Index>(k));
  }
  return out;
}

/// References say little about temperatures that they did not have: 10 K away they say nothing.
void widen_outside(const Design& design, double outside, const std::vector<double>& size, MatrixXd& variance) {
  constexpr double kForgotten = 18.0, kMost = 0.4;  // K; usual sizes of the channel
  const double share = outside / kForgotten;
  for (std::size_t k = 0; k < design.columns.size(); ++k) {
    const Column& column = design.columns[k];
    const auto i = static_cast<Index>(k);
    if (column.cause >= 0 || column.free > 0.0) continue;
    for (std::size_t c = 0; c < column.effect.size(); ++c) {
      const double of_usual = size.empty() ? 1.0 : size[c];
      if (column.effect[c].size() > 0) variance(i, i) += std::pow(of_usual * share * std::min(kMost, column.usual), 2);
    }
  }
}

/// How good the model is in a channel: what these logs miss there, over what shapes of usual sizes would make of it. A
/// model that errs by a few millivolts at the temperatures that were driven errs by about as much at others.
double size_of_errors(const std::vector<const Design*>& designs, const std::string& channel,
                      const std::vector<std::size_t>& teachers) {
  constexpr double kTimes = 5.0;  // as much as in these logs, and a margin
  double seen = 0.0, expected = 0.0;
  for (const std::size_t k : teachers) {
    const Design& design = *designs[k];
    for (std::size_t c = 0; c < design.comparison.channels.size(); ++c) {
      if (design.comparison.channels[c].name != channel) continue;
      seen += std::pow(rms_of(design.residual[c]), 2);
      for (const Index i : shapes_on(design, c)) {
        const Column& column = design.columns[static_cast<std::size_t>(i)];
        expected += std::pow(column.usual * rms_of(column.effect[c]), 2);
      }
    }
  }
  return expected > 0.0 ? std::min(1.0, kTimes * std::sqrt(seen / expected)) : 1.0;
}

/// The logs that are given by their numbers teach; each by its sums of every channel.
Learned learned(const Design& design, const std::vector<const Design*>& designs,
                const std::vector<std::vector<BlockSum>>& said,
                const std::vector<std::size_t>& teachers) {
  const auto p = static_cast<Index>(design.columns.size());
  Learned out{VectorXd::Zero(p), MatrixXd::Zero(p, p), {}};
  for (std::size_t c = 0; c < design.comparison.channels.size(); ++c) {
    const std::vector<Index> columns = shapes_on(design, c);
    std::vector<LogSums> logs;
    for (const std::size_t k : teachers) logs.push_back({said[k][c].gram(columns, columns), said[k][c].score(columns)});
    ColumnPrior prior = prior_of(design, columns);
    out.size.push_back(size_of_errors(designs, design.comparison.channels[c].name, teachers));
    prior.usual *= out.size.back();
    const MixedModel model = mixed_model(logs, prior, kRounds);
    out.mean(columns) = model.mean;
    out.variance(columns, columns) = model.variance();
  }
  return out;
}

/// Numbers of all references but one, or of all (-1).
std::vector<std::size_t> all_but_one(std::size_t references, int without) {
  std::vector<std::size_t> out;
  for (std::size_t k = 0; k < references; ++k) {
    if (static_cast<int>(k) != without) out.push_back(k);
  }
  return out;
}

/// V of a log's shapes: what was learned, and more in the voltage of the cells, where few references tell less than they
/// seem to. From sound logs that no reference was; shapes that follow the current at once, and others.
MatrixXd widened(const Design& design, const Learned& learned) {
  constexpr double kAtOnce = 100.0, kLate = 30.0;
  MatrixXd out = learned.variance;
  if (design.comparison.channels.front().balance != Balance::kVoltage) return out;
  for (const Index i : shapes_on(design, 0)) {
    const double root = std::sqrt(is_late_kind(design.columns[static_cast<std::size_t>(i)].kin) ? kLate : kAtOnce);
    out.row(i) *= root;
    out.col(i) *= root;
  }
  return out;
}

/// Mean and V of a log of these sums by channel, from the references but `without`.
Usual expected_of(const Design& design, const Design& log, const std::vector<BlockSum>& sums,
                  const Knowledge& knowledge, int without) {
  const Learned& learned = without < 0 ? knowledge.of_all : knowledge.of_the_others[static_cast<std::size_t>(without)];
  const std::vector<std::size_t> teachers = all_but_one(knowledge.designs.size(), without);
  Usual out;
  out.mean = learned.mean;
  out.variance = widened(design, learned);
  if (!teachers.empty()) {
    std::vector<const Design*> designs;
    for (const std::size_t k : teachers) designs.push_back(knowledge.designs[k]);
    widen_outside(design, outside_k(log, designs), learned.size, out.variance);
    bound_projections(design, sums, knowledge.said, teachers, out.mean, out.variance);
  }
  out.variance.diagonal() += always_free(design, !teachers.empty());
  return out;
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
      const bool same_members = groups[r].members == design.comparison.groups[g].members;
      if (same_members && theirs.gram.rows() == shapes) out.push_back(&theirs);
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
VectorXd surprise_of(const std::vector<LogSums>& logs, const ColumnPrior& prior, double widening) {
  VectorXd out = VectorXd::Zero(prior.usual.size());
  for (std::size_t k = 0; logs.size() > 1 && k < logs.size(); ++k) {
    std::vector<LogSums> others = logs;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(k));
    const MixedModel model = mixed_model(others, prior, kRoundsOfMembers);
    const VectorXd rest = logs[k].score - logs[k].gram * model.mean;
    const VectorXd expected = (logs[k].gram + widening * logs[k].gram * model.variance() * logs[k].gram).diagonal();
    out += (rest.cwiseAbs2().cwiseQuotient(expected.cwiseMax(1e-300))) / static_cast<double>(logs.size());
  }
  return out;
}

/// From references: each member as it is known to be, and what all of them change from log to log.
void members_of_references(const std::vector<const GroupScore*>& references,
                           const std::vector<Shape>& shapes_of_group, double widening, Usual& out) {
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
  const double asked = std::ceil(static_cast<double>(members) / static_cast<double>(every));
  const double by_chance = 1.0 + 2.0 * std::sqrt(2.0 / (asked * static_cast<double>(references.size())));
  for (Index i = 0; i < members; ++i) {
    std::vector<LogSums> logs;
    for (const GroupScore* reference : references) logs.push_back({reference->gram, reference->score.col(i)});
    if (i % every == 0) surprise += surprise_of(logs, prior, widening) / asked;
    const MixedModel model = mixed_model(logs, prior, kRoundsOfMembers);
    mean.col(i) = model.mean;
    variance += model.mean_covariance / static_cast<double>(members);
    variance.diagonal() += model.between / static_cast<double>(members);
  }
  out.group_mean.push_back(mean);
  out.group_variance.push_back(widening * variance);
  out.group_inflation.push_back(std::max(1.0, surprise.maxCoeff() / by_chance));
}

void learn_groups(const Design& design, const Score& score, const std::vector<Reference>& references, Usual& out) {
  constexpr double kOfCells = 3.3;  // what few references tell of a cell's voltage is less than they seem to
  for (std::size_t g = 0; g < score.groups.size(); ++g) {
    const bool thermal = design.comparison.groups[g].balance == Balance::kHeat;
    const auto theirs = same_group(design, g, score.groups[g].score.rows(), references);
    if (theirs.empty()) {
      members_of_one_log(score.groups[g], thermal, out);
    } else {
      members_of_references(theirs, design.shapes[g], thermal ? 1.0 : kOfCells, out);
    }
  }
}

/// What sound logs show of each cause, each judged by the others, is what differs from log to log: its variance.
VectorXd seen_of_causes(const Design& design, const std::vector<Remaining>& sound) {
  constexpr double kLeast = 2e-3, kBetweenSensors = 5e-4, kWeight = 1.0, kStart = 50.0;  // typical sizes; logs; of the least
  std::vector<Index> columns;
  for (std::size_t k = 0; k < design.columns.size(); ++k) {
    const Column& column = design.columns[k];
    if (column.cause >= 0 && !column.key.starts_with("local/")) columns.push_back(static_cast<Index>(k));
  }
  ColumnPrior prior = prior_of(design, columns);
  for (std::size_t k = 0; k < columns.size(); ++k) prior.kin[k] = k;
  prior.usual.setConstant(1e-6);
  for (std::size_t k = 0; k < columns.size(); ++k) {
    const Column& column = design.columns[static_cast<std::size_t>(columns[k])];
    const bool of_sensors = column.balance == Balance::kVoltage && column.effect[0].size() == 0;
    prior.repeats(static_cast<Index>(k)) = of_sensors ? kBetweenSensors : kLeast;
  }
  prior.columns = kWeight;
  prior.start = kStart;
  std::vector<LogSums> logs;
  for (const Remaining& log : sound) logs.push_back({log.information(columns, columns), log.score(columns)});
  VectorXd out = VectorXd::Zero(static_cast<Index>(design.columns.size()));
  out(columns) = mixed_model(logs, prior, kRounds).between;
  return out;
}

/// Sums of a reference's channel in the order of another log's columns; a column that it lacks says nothing.
BlockSum in_order_of(const Design& design, const Reference& reference, const std::vector<BlockSum>& blocks) {
  BlockSum own = empty_sum(reference.score.columns());
  for (const BlockSum& block : blocks) own.add(block);
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

/// Every channel of a reference that the log has too, in the log's order; nothing of one that it lacks.
std::vector<BlockSum> said_by(const Design& design, const Reference& reference) {
  std::vector<BlockSum> out;
  for (const BalanceChannel& channel : design.comparison.channels) {
    const auto& theirs = reference.design->comparison.channels;
    const auto found = std::find_if(theirs.begin(), theirs.end(),
                                    [&](const BalanceChannel& c) { return c.name == channel.name; });
    const bool has = found != theirs.end();
    out.push_back(has ? in_order_of(design, reference,
                                    reference.score.channels[static_cast<std::size_t>(found - theirs.begin())])
                      : empty_sum(static_cast<Index>(design.columns.size())));
  }
  return out;
}

}  // namespace

Knowledge knowledge_of(const Design& design, const std::vector<Reference>& references) {
  Knowledge out;
  std::vector<std::size_t> all;
  for (const Reference& reference : references) {
    all.push_back(out.designs.size());
    out.designs.push_back(reference.design);
    out.said.push_back(said_by(design, reference));
  }
  if (references.empty()) {
    const auto p = static_cast<Index>(design.columns.size());
    out.of_all = {VectorXd::Zero(p), MatrixXd::Zero(p, p), {}};
    return out;
  }
  out.of_all = learned(design, out.designs, out.said, all);
  for (std::size_t k = 0; all.size() > 1 && k < all.size(); ++k) {
    std::vector<std::size_t> others = all;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(k));
    out.of_the_others.push_back(learned(design, out.designs, out.said, others));
  }
  return out;
}

Remaining reference_by_the_others(const Design& design, const Knowledge& knowledge, std::size_t reference,
                                  const std::vector<double>& inflation, int channel) {
  BlockSum sum = empty_sum(static_cast<Index>(design.columns.size()));
  for (std::size_t c = 0; c < knowledge.said[reference].size(); ++c) {
    if (channel >= 0 && static_cast<std::size_t>(channel) != c) continue;
    sum.add(knowledge.said[reference][c], 1.0 / inflation[c]);
  }
  const Usual usual = expected_of(design, *knowledge.designs[reference], knowledge.said[reference], knowledge,
                                  static_cast<int>(reference));
  return remaining(sum, usual);
}

Usual usual_shapes(const Design& design, const std::vector<BlockSum>& said, const Knowledge& knowledge,
                   const std::vector<double>& inflation) {
  Usual out = expected_of(design, design, said, knowledge, -1);
  out.references = knowledge.designs.size();
  out.inflation = inflation;
  return out;
}

Usual usual_discrepancy(const Design& design, const Score& score, const std::vector<Reference>& references,
                        const Knowledge& knowledge, const std::vector<double>& inflation) {
  Usual out = usual_shapes(design, channel_totals(score), knowledge, inflation);
  if (references.empty()) {
    for (std::size_t c = 0; c < score.channels.size(); ++c) out.inflation[c] = inflation_of(score.channels[c]);
  }
  out.seen = VectorXd::Zero(static_cast<Index>(design.columns.size()));
  if (references.size() > 1) {
    std::vector<Remaining> sound;
    for (std::size_t k = 0; k < references.size(); ++k) {
      sound.push_back(reference_by_the_others(design, knowledge, k, inflation));
    }
    out.seen = seen_of_causes(design, sound);
  }
  out.variance.diagonal() += out.seen;
  learn_groups(design, score, references, out);
  return out;
}

Usual group_spread(const Design& design, const Score& score, const std::vector<Reference>& references) {
  Usual out;
  learn_groups(design, score, references, out);
  return out;
}

Remaining remaining(const BlockSum& sum, const Usual& usual) {
  const Index p = sum.score.size();
  std::vector<Index> told;  // the others stay at zero, and a matrix costs the cube of its size
  for (Index k = 0; k < p; ++k) {
    if (sum.gram(k, k) > 0.0) told.push_back(k);
  }
  const MatrixXd gram = sum.gram(told, told);
  const VectorXd unusual = sum.score(told) - gram * usual.mean(told);
  const Discount discount(gram, usual.variance(told, told));
  Remaining out{MatrixXd::Zero(p, p), VectorXd::Zero(p)};
  out.information(told, told) = discount.information();
  out.score(told) = discount.score(unusual).col(0);
  return out;
}

}  // namespace voltlap::plant
