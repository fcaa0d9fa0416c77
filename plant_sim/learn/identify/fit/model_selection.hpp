// SPDX-License-Identifier: Apache-2.0
// What the recordings themselves must decide where the circuit is only an approximation: smoothness and number of
// branches, by how well a half of the pulses predicts the other half.
#pragma once
#include <utility>
#include <vector>

#include "learn/identify/circuit/fitted_circuit.hpp"
#include "learn/identify/recording/holdout_blocks.hpp"

namespace voltlap::plant {

/// Smoothness, held-out rms [V].
using SmoothnessScores = std::vector<std::pair<double, double>>;

/// The smoothest weight whose held-out error is above the least by no more than one standard error of their
/// difference. Neighbours of the best are tried, by factors of two, until it stands between two worse ones.
/// A plain circuit has the OCV alone to choose it for: a free OCV would take over what constant resistances miss.
[[nodiscard]] double choose_smoothness(const std::vector<MeasuredRun>& runs, const Eigen::VectorXd& taus,
                                       FitPriors priors, SmoothnessScores& scores);

/// How rough the OCV may be, `FitPriors::em_roughness_v`: that with which a half of the recordings, in about twenty
/// stretches each, predicts the other half best. Recordings that disagree would else be joined by a curve that swings.
[[nodiscard]] double choose_ocv_roughness(const std::vector<MeasuredRun>& runs, const Eigen::VectorXd& taus,
                                          FitPriors priors);

/// A plain circuit beside tables over SOC: what each predicts of stretches that were kept back, about ten of each
/// recording in turn, the resistances and time constants free.
struct PlainScore {
  double plain_v = 0.0, tables_v = 0.0;
  /// Not worse by more than one standard error of the difference, and all rows are followed nearly as well.
  bool is_enough = false;
};
[[nodiscard]] PlainScore score_plain(const std::vector<MeasuredRun>& runs, const Eigen::VectorXd& taus,
                                     const FitPriors& priors);

struct OrderScore {
  int branches;
  double heldout_rms_v, information_criterion;
};
/// One branch, two and so on up to `most`, until one more does not predict better. Where more than two may be taken,
/// time constants are free over SOC, as they are in the end: a branch more would else be taken for what they do there.
[[nodiscard]] std::vector<OrderScore> score_orders(const std::vector<MeasuredRun>& runs, const FitPriors& priors,
                                                   Eigen::Index most);
/// That of the scores which predicts held-out pulses best, as few as possible: each more is better by 5 %.
[[nodiscard]] Eigen::Index best_order(const std::vector<OrderScore>& orders);

}  // namespace voltlap::plant
