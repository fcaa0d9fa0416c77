// SPDX-License-Identifier: Apache-2.0
// How much smaller the errors are with a set of causes: on blocks that did not fit it, by cause, and row by row.
#pragma once
#include <vector>

#include "discrepancy/explain.hpp"
#include "discrepancy/judged.hpp"

namespace voltlap::plant {

/// RMS of the rows that are compared, those with a value; 0 where there are none.
[[nodiscard]] double rms_of(const Eigen::VectorXd& values);

/// RMS of a noise, its slow part included.
[[nodiscard]] double noise_rms(const Noise& noise);

/// RMS of every channel on blocks that were kept back, without and with the set.
void measure_gain(const Judged& judged, const RefinedSet& set, Explanation& out);

/// By cause the largest share of a channel's squares that it takes away: the mean over all orders in which the causes
/// can be added (Shapley), since what one levels another may need.
[[nodiscard]] std::vector<double> shares_of(const Judged& judged, const std::vector<RefinedCause>& causes);

/// The largest share of a channel's squares that all of them take away together.
[[nodiscard]] double share_together(const Judged& judged, const std::vector<RefinedCause>& causes);

/// Where an error becomes smaller.
enum class Pays {
  kNot,
  kInNoise,  ///< only once what is slow is filtered out: surely, however little of the whole it is
  kPlainly,  ///< in most blocks and by a part that matters, as it is or after what references say of it
};

/// What a set, its sizes as the evidence has them, makes of the error of a channel (or of a member that it acts on).
/// What acts only where one sensor is held against another need not pay: no model stands between them. `beside`: others
/// that are there already.
[[nodiscard]] Pays pays(const Judged& j, const std::vector<std::size_t>& members,
                        const std::vector<std::size_t>& beside = {});

/// Residuals without and with the set, for pictures.
void keep_traces(const Judged& judged, const RefinedSet& set, Explanation& out);

}  // namespace voltlap::plant
