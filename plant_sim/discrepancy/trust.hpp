// SPDX-License-Identifier: Apache-2.0
// How far references are believed: each is judged by the others, and what it then seems to show is what a sound log
// may show. A channel in which it shows much counts less: its noise is inflated.
#pragma once
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "discrepancy/candidates.hpp"

namespace voltlap::plant {

struct TrustProblem {
  const Design& design;
  const std::vector<BlockSum>& said;  ///< by the log, by channel
  const Knowledge& knowledge;
  const System& system;  ///< its candidates
};

/// Largest plain error of a channel of the log over that of any reference in it, and which; 0 without references.
/// `of`: channels of this balance alone.
[[nodiscard]] std::pair<double, std::string> times_usual(const Design& design, const std::vector<Reference>& references,
                                                         std::optional<Balance> of = std::nullopt);

/// What effects have room for in a log of these sums by channel, beside what is usual in the references but `without`.
[[nodiscard]] std::vector<Bound> bounds_of(const std::vector<BlockSum>& channels, const Knowledge& knowledge,
                                           int without = -1);

/// Largest RMS that a channel has in a reference.
[[nodiscard]] double usual_rms(const std::vector<Reference>& references, const std::string& channel);

/// The same for a world that was refined, in the plain RMS of each channel, noise to spare. True without references.
[[nodiscard]] bool has_room(const Design& design, const std::vector<Reference>& references, const NoiseModel& noise,
                            const World& refined);

/// What references are asked about.
enum class Asked { kAll, kNotOfAllCells };

/// Best evidence that a reference has when the others judge it, in one channel or (-1) in all.
[[nodiscard]] double evidence_of_references(const TrustProblem& problem, const Usual& usual,
                                            const std::vector<double>& inflation, int channel = -1,
                                            Asked asked = Asked::kAll);

/// Of the noise, by channel: a channel in which sound logs show evidence counts less, until they show none.
[[nodiscard]] std::vector<double> inflation_by_references(const TrustProblem& problem, const Usual& usual);

}  // namespace voltlap::plant
