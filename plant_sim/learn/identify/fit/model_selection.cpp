// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/fit/model_selection.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/demand.hpp"
#include "core/parameters.hpp"
#include "learn/identify/fit/uncertainty.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;

constexpr double kWindow = 120.0;  // s of a held-out pulse
constexpr int kSearchEvaluations = 30;
constexpr double kWorthIt = 0.95, kMoreThanTwo = 0.9;  // of the error: a branch more must predict better by this

/// Blocks of each recording, of which every second is kept back in turn.
using Blocks = std::vector<std::vector<Block>>;

/// Pulses with their first two minutes; without pulses, minutes.
Blocks pulses_of(const std::vector<MeasuredRun>& runs) {
  constexpr std::size_t kFewest = 4;
  Blocks out;
  for (const MeasuredRun& run : runs) {
    out.push_back(pulse_windows(run, kWindow));
    if (out.back().size() < kFewest) out.back() = time_blocks(run, kWindow);
  }
  return out;
}

/// About twenty of each recording.
Blocks stretches_of(const std::vector<MeasuredRun>& runs) {
  constexpr double kStretches = 20.0;
  Blocks out;
  for (const MeasuredRun& run : runs) {
    const double seconds = (run.time_s(run.rows() - 1) - run.time_s(0)) / kStretches;
    out.push_back(time_blocks(run, std::max(kWindow, seconds)));
  }
  return out;
}

/// Both halves kept back in turn and predicted by `fit` of the other. `from_onset`: only what the block itself adds.
template <class Fit>
BlockScore score_by(const Fit& fit, const std::vector<MeasuredRun>& runs, const Blocks& blocks, bool from_onset) {
  VOLTLAP_DEMAND(!runs.empty() && blocks.size() == runs.size());
  BlockScore total;
  for (const std::size_t first : {std::size_t{0}, std::size_t{1}}) {
    std::vector<MeasuredRun> kept;
    for (std::size_t k = 0; k < runs.size(); ++k)
      kept.push_back(without_every_second(runs[k], blocks[k], (first + k) % 2));
    const auto errors = errors_of(fit(kept), runs);
    for (std::size_t k = 0; k < runs.size(); ++k) {
      const Eigen::VectorXd error = from_onset ? since_onset(errors[k], blocks[k]) : errors[k];
      const BlockScore one = score_every_second(runs[k], error, blocks[k], (first + k) % 2);
      total.parts.insert(total.parts.end(), one.parts.begin(), one.parts.end());
    }
  }
  return total;
}

/// By a linear fit, of pulses from their onset.
BlockScore heldout_score(const std::vector<MeasuredRun>& runs, const Eigen::VectorXd& taus, const FitPriors& priors) {
  const auto fit = [&](const std::vector<MeasuredRun>& kept) { return linear_fit(kept, taus, priors); };
  return score_by(fit, runs, pulses_of(runs), true);
}

}  // namespace

double choose_ocv_roughness(const std::vector<MeasuredRun>& runs, const Eigen::VectorXd& taus, FitPriors priors) {
  constexpr double kFactor = 4.0;
  constexpr int kTried = 6;
  const Blocks stretches = stretches_of(runs);
  const auto score = [&](double roughness_v) {
    priors.em_roughness_v = roughness_v;
    const auto fit = [&](const std::vector<MeasuredRun>& kept) { return linear_fit(kept, taus, priors); };
    return score_by(fit, runs, stretches, false).mean();
  };
  double best = priors.em_roughness_v, least = score(best);
  for (int k = 1; k < kTried; ++k) {
    const double tried = best / kFactor, at = score(tried);
    if (at >= least) break;
    best = tried;
    least = at;
  }
  return best;
}

PlainScore score_plain(const std::vector<MeasuredRun>& runs, const Eigen::VectorXd& taus, const FitPriors& priors) {
  const Blocks blocks = stretches_of(runs);
  const auto score = [&](bool constant) {
    FitPriors own = priors;
    own.constant = constant;
    const auto fit = [&](const std::vector<MeasuredRun>& kept) { return table_fit(kept, taus, own).fit; };
    return score_by(fit, runs, blocks, false);
  };
  const auto left = [&](bool constant) {
    FitPriors own = priors;
    own.constant = constant;
    return std::sqrt(mean_square(runs, errors_of(table_fit(runs, taus, own).fit, runs)));
  };
  constexpr double kFollows = 1.25;
  const BlockScore plain = score(true), tables = score(false);
  const bool no_worse = plain.mean() <= tables.mean() + standard_error_of_difference(plain, tables);
  return {plain.mean(), tables.mean(), no_worse && left(true) <= kFollows * left(false)};
}

double choose_smoothness(const std::vector<MeasuredRun>& runs, const Eigen::VectorXd& taus, FitPriors priors,
                         SmoothnessScores& scores) {
  constexpr int kWidest = 7;  // 2^-7 to 2^7
  constexpr std::size_t kLeastParts = 4;
  std::map<int, BlockScore> tried;  // by the exponent
  const auto score_at = [&](int exponent) -> const BlockScore& {
    auto [at, is_new] = tried.try_emplace(exponent);
    if (is_new) {
      priors.smoothness = std::pow(2.0, exponent);
      at->second = heldout_score(runs, taus, priors);
    }
    return at->second;
  };
  int best = 0;
  if (priors.constant && score_at(best).parts.size() < kLeastParts) return 1.0;  // an OCV that no other part judges
  for (const int direction : {1, -1}) {
    while (std::abs(best) < kWidest && score_at(best + direction).mean() < score_at(best).mean()) best += direction;
  }
  // The score need not rise steadily: each is tried, from the smoothest.
  int smoothest = -kWidest;
  while (score_at(smoothest).mean() >
         score_at(best).mean() + standard_error_of_difference(score_at(smoothest), score_at(best)))
    ++smoothest;
  VOLTLAP_DEMAND(smoothest >= -kWidest && smoothest <= kWidest + 1);
  for (const auto& [exponent, score] : tried) scores.emplace_back(std::pow(2.0, exponent), score.mean());
  return std::pow(2.0, smoothest);
}

std::vector<OrderScore> score_orders(const std::vector<MeasuredRun>& runs, const FitPriors& priors, Index most) {
  VOLTLAP_DEMAND(most >= 1 && most <= static_cast<Index>(kMostCellBranches));
  std::vector<OrderScore> out;
  for (Index branches = 1; branches <= most; ++branches) {
    const CircuitFit fit(runs, branches, priors);
    const Eigen::VectorXd taus = fit.search_taus(first_taus(branches), kSearchEvaluations);
    const bool whole = most > 2 && !priors.constant;
    const auto fitted = [&](const std::vector<MeasuredRun>& to) {
      return whole ? table_fit(to, taus, priors).fit : linear_fit(to, taus, priors);
    };
    const auto errors = errors_of(fitted(runs), runs);
    const double square = mean_square(runs, errors), density = noise_density(runs, errors);
    double seconds = 0.0;
    for (const MeasuredRun& run : runs) seconds += run.weight_s.sum();
    const double samples = std::max(2.0, seconds * square / density);  // independent ones
    const double parameters = static_cast<double>((2 * branches + 1) * fit.r_count());
    out.push_back({static_cast<int>(branches), score_by(fitted, runs, pulses_of(runs), true).mean(),
                   samples * std::log(square) + parameters * std::log(samples)});
    if (best_order(out) < branches) break;
  }
  return out;
}

Index best_order(const std::vector<OrderScore>& orders) {
  VOLTLAP_DEMAND(!orders.empty());
  std::size_t best = 0;
  const auto worth = [&](std::size_t at) { return orders[at].branches > 2 ? kMoreThanTwo : kWorthIt; };
  while (best + 1 < orders.size() && orders[best + 1].heldout_rms_v < worth(best + 1) * orders[best].heldout_rms_v)
    ++best;
  return orders[best].branches;
}

}  // namespace voltlap::plant
