// SPDX-License-Identifier: Apache-2.0
#include "discrepancy/named_part.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "discrepancy/discount.hpp"
#include "discrepancy/gain.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using UseRow = std::function<bool(Index)>;

constexpr double kPiece = 10.0;       // s
constexpr std::size_t kFolds = 4;     // every fourth piece is kept back
constexpr double kNearNoise = 3.0;    // floors
constexpr std::size_t kKept = 300;    // sets that are tried on pieces that were kept back

std::size_t piece_of(const Judged& j, Index row) {
  const VectorXd& time = j.design.comparison.log.time_s;
  return static_cast<std::size_t>((time(row) - time(0)) / kPiece);
}

std::size_t minute_of(const Judged& j, Index row) {
  const VectorXd& time = j.design.comparison.log.time_s;
  return static_cast<std::size_t>((time(row) - time(0)) / kBlock);
}

bool is_used(const Judged& j, Index row) { return j.use.empty() || j.use[minute_of(j, row)]; }

/// Residuals beyond what the references always show.
std::vector<VectorXd> new_residuals(const Judged& j) {
  std::vector<VectorXd> out = j.design.residual;
  for (std::size_t c = 0; c < out.size(); ++c) {
    for (std::size_t k = 0; k < j.design.columns.size(); ++k) {
      const VectorXd& effect = j.design.columns[k].effect[c];
      const double usual = j.usual.mean(static_cast<Index>(k));
      if (effect.size() > 0 && usual != 0.0) out[c] -= usual * effect;
    }
  }
  return out;
}

/// White, and as large as the error itself: a piece then has the weight of one value. Errors near the noise count less.
NoiseModel plain_noise(const Judged& j, const std::vector<VectorXd>& residual) {
  NoiseModel out = j.noise;
  const Comparison& on = j.design.comparison;
  for (std::size_t c = 0; c < on.channels.size(); ++c) {
    double square = 0.0, rows = 0.0;
    std::vector<bool> seen(piece_of(j, on.log.rows() - 1) + 1, false);
    for (Index row = 0; row < on.log.rows(); ++row) {
      const double r = residual[c](row);
      if (!std::isfinite(r) || !is_used(j, row)) continue;
      square += r * r;
      rows += 1.0;
      seen[piece_of(j, row)] = true;
    }
    const auto pieces = static_cast<double>(std::count(seen.begin(), seen.end(), true));
    const double floor = kNearNoise * noise_rms(j.noise.at(on.channels[c].name));
    if (square > 0.0) out[on.channels[c].name] = {std::sqrt((square + rows * floor * floor) / pieces), 0.0, 1.0, 0.0};
  }
  return out;
}

/// What nobody can know stays free; nothing else is usual.
Usual nothing_usual(const Judged& j) {
  Usual out = j.usual;
  const VectorXd free = out.variance.diagonal();
  out.variance.setZero();
  for (std::size_t k = 0; k < j.design.columns.size(); ++k) {
    const Column& column = j.design.columns[k];
    const bool start = column.key.starts_with("initial_soc/") && !j.design.comparison.facts.starts_at_rest;
    const auto at = static_cast<Index>(k);
    if (column.free > 0.0 || start) out.variance(at, at) = free(at);
  }
  std::fill(out.inflation.begin(), out.inflation.end(), 1.0);
  return out;
}

/// Causes that act on everything, and what is free.
std::vector<Index> columns_of(const Judged& j) {
  std::vector<Index> out;
  for (std::size_t k = 0; k < j.design.columns.size(); ++k) {
    const Column& column = j.design.columns[k];
    if ((column.cause >= 0 && !column.key.starts_with("local/")) || column.free > 0.0) out.push_back(static_cast<Index>(k));
  }
  return out;
}

/// Gram, score and energy of some rows in units of the view's noise.
BlockSum sum_over(const Judged& j, const PlainView& view, const std::vector<Index>& columns, const UseRow& use) {
  const auto q = static_cast<Index>(columns.size());
  BlockSum out = empty_sum(q);
  for (std::size_t c = 0; c < j.design.residual.size(); ++c) {
    const VectorXd& residual = view.residual[c];
    std::vector<Index> rows;
    for (Index row = 0; row < residual.size(); ++row) {
      if (std::isfinite(residual(row)) && is_used(j, row) && use(row)) rows.push_back(row);
    }
    const double scale = 1.0 / view.noise.at(j.design.comparison.channels[c].name).white;
    MatrixXd x = MatrixXd::Zero(static_cast<Index>(rows.size()), q);
    for (Index k = 0; k < q; ++k) {
      const VectorXd& effect = j.design.columns[static_cast<std::size_t>(columns[static_cast<std::size_t>(k)])].effect[c];
      if (effect.size() > 0) x.col(k) = scale * effect(rows);
    }
    const VectorXd y = scale * residual(rows);
    out.gram += x.transpose() * x;
    out.score += x.transpose() * y;
    out.energy += y.squaredNorm();
  }
  return out;
}

/// With the place of every column, free ones marginalised.
System system_over(const Judged& j, const PlainView& view, const std::vector<Index>& columns, const UseRow& use) {
  const BlockSum sum = sum_over(j, view, columns, use);
  const MatrixXd variance = view.usual.variance(columns, columns);
  const Discount discount(sum.gram, variance);
  const auto p = static_cast<Index>(j.design.columns.size());
  System out{j.system.candidates, MatrixXd::Zero(p, p), VectorXd::Zero(p), j.system.prior_variance, {}};
  out.information(columns, columns) = discount.information();
  out.score(columns) = discount.score(sum.score).col(0);
  return out;
}

/// With the prior of each size.
VectorXd sizes_by(const System& system, const std::vector<Index>& rows) {
  MatrixXd a = system.information(rows, rows);
  a.diagonal() += system.prior_variance(rows).cwiseInverse();
  const VectorXd score = system.score(rows);
  return a.ldlt().solve(score);
}

/// Drop of the squares on folds that did not fit.
double held_out_gain(const std::vector<System>& folds, const std::vector<System>& others, const std::vector<Index>& rows) {
  double gain = 0.0;
  for (std::size_t fold = 0; fold < folds.size(); ++fold) {
    const VectorXd sizes = sizes_by(others[fold], rows);
    gain += 2.0 * sizes.dot(folds[fold].score(rows)) - sizes.dot(folds[fold].information(rows, rows) * sizes);
  }
  return gain;
}

/// The candidates with a name that act on everything, and their places in the whole system.
System named_only(const System& whole, std::vector<std::size_t>& places) {
  System out{{}, whole.information, whole.score, whole.prior_variance, {}};
  for (std::size_t k = 0; k < whole.candidates.size(); ++k) {
    if (whole.candidates[k].cause < 0 || whole.candidates[k].group >= 0) continue;
    out.candidates.push_back(whole.candidates[k]);
    places.push_back(k);
  }
  return out;
}

/// What is left is the noise that sizes are known by, not what was there before.
void count_by_remainder(double share, PlainView& view) {
  const auto count = [share](System& system) {
    system.information /= share;
    system.score /= share;
  };
  for (auto& [name, noise] : view.noise) noise.white *= std::sqrt(share);
  count(view.system);
  for (System& quarter : view.parts.quarters) count(quarter);
}

}  // namespace

PlainView plain_view(const Judged& j) {
  PlainView out{{}, {}, nothing_usual(j), {}, {}, {}};
  out.residual = new_residuals(j);
  out.noise = plain_noise(j, out.residual);
  const std::vector<Index> columns = columns_of(j);
  std::vector<System> folds, others;
  for (std::size_t k = 0; k < kFolds; ++k) {
    folds.push_back(system_over(j, out, columns, [&](Index row) { return piece_of(j, row) % kFolds == k; }));
    out.parts.quarters.push_back(system_over(j, out, columns, [&](Index row) { return minute_of(j, row) % kFolds == k; }));
  }
  for (std::size_t k = 0; k < kFolds; ++k) others.push_back(all_but(folds, k));
  const UseRow all = [](Index) { return true; };
  out.system = system_over(j, out, columns, all);
  const double energy = sum_over(j, out, {}, all).energy;
  std::vector<std::size_t> places;
  for (WeighedSet& set : weigh_sets(named_only(out.system, places), kKept)) {
    for (std::size_t& member : set.members) member = places[member];
    const double gain = held_out_gain(folds, others, rows_of(out.system, set.members)) / energy;
    set.evidence = -0.5 * energy * std::log1p(-std::min(gain, 1.0 - 1e-9));
    out.sets.push_back(std::move(set));
  }
  std::stable_sort(out.sets.begin(), out.sets.end(),
                   [](const WeighedSet& a, const WeighedSet& b) { return a.evidence > b.evidence; });
  if (!out.sets.empty()) count_by_remainder(std::exp(-2.0 * out.sets[0].evidence / energy), out);
  return out;
}

Refinery plain_refinery(const Judged& j, const PlainView& view) {
  return {j.design, j.causes, view.system, view.noise, view.usual, rows_of_blocks(j.design, j.use)};
}

void widen_by_minutes(const PlainView& view, const Judged& j, RefinedSet& set) {
  const std::vector<Index> rows = rows_of(view.system, members_of(set));
  std::vector<Index> columns = rows;
  for (std::size_t k = 0; k < j.design.columns.size(); ++k) {
    if (j.design.columns[k].free > 0.0) columns.push_back(static_cast<Index>(k));
  }
  VectorXd sum = VectorXd::Zero(static_cast<Index>(rows.size())), square = sum;
  double count = 0.0;
  for (std::size_t b = 0; b <= minute_of(j, j.design.comparison.log.rows() - 1); ++b) {
    if (!j.use.empty() && !j.use[b]) continue;
    const VectorXd sizes = sizes_by(system_over(j, view, columns, [&](Index row) { return minute_of(j, row) != b; }), rows);
    sum += sizes;
    square += sizes.cwiseAbs2();
    count += 1.0;
  }
  const VectorXd sigma = ((square - sum.cwiseAbs2() / count).cwiseMax(0.0) * ((count - 1.0) / count)).cwiseSqrt();
  Index at = 0;
  for (RefinedCause& fit : set.causes) {
    const Candidate& c = view.system.candidates[fit.candidate];
    for (const std::size_t parameter : c.parameters) {
      fit.sigma[parameter] = sigma(at++) * cause_of(j, fit.candidate).parameters[parameter].typical;
    }
  }
}

}  // namespace voltlap::plant
