// SPDX-License-Identifier: Apache-2.0
// Which set is the answer, and how sure that is: size of the set, classes that the data cannot tell apart, rivals,
// null, separation, priors, held-out gain, stability.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "discrepancy/parts.hpp"
#include "discrepancy/refine.hpp"

namespace voltlap::plant {

/// ln 20: what a set's evidence must be ahead by.
inline constexpr double kDecisive = 2.995732;
/// What a larger set must be ahead by: six of 263 sound logs of the bank reach it beside nothing at all.
inline constexpr double kLarger = 2.0 * kDecisive;
inline constexpr double kSeparation = 3.3;    ///< d'
/// Of 174 sound logs of 15 worlds 4 are given a cause at 1 %, 2 at this.
inline constexpr double kNullLevel = 0.005;
inline constexpr double kSameClass = 0.98;    ///< overlap from which two sets are one class

struct Decision {
  std::vector<std::size_t> members;                   ///< empty: nothing beyond the noise
  std::vector<std::vector<std::size_t>> equivalents;  ///< by member: candidates that could stand in its place
  std::vector<std::size_t> rivals;                    ///< of `sets`: named, of another class, not clearly worse
  bool anonymous = false;                             ///< the best set holds a shape without a name
  std::optional<std::size_t> named_rival;             ///< then: the best set with names only, if it is close
  double margin = 0.0;                                ///< to the next set of another class
  double null_probability = 1.0;
  double next_gain = 0.0;                             ///< what one more candidate would add to the evidence
};

/// The same cause in the same place, in this form or another.
[[nodiscard]] bool same_name(const System& system, std::size_t a, std::size_t b);

/// Does one of them act on the voltage or the charge that all cells share?
[[nodiscard]] bool is_of_all_cells(const System& system, const std::vector<std::size_t>& members);

/// Degrees of freedom of the scale of a sound log's scores. In the voltage and the charge that all cells share
/// references tell least: 19 of the 22 alarms of 600 sound logs of the bank were there, 16 of them beyond these.
inline constexpr double kFreedom = 20.0, kFreedomOfCells = 14.0;

/// The best of `sets`, if chance reaches its evidence in no more than kNullLevel of sound logs.
[[nodiscard]] Decision decide(const System& system, const std::vector<WeighedSet>& sets, int draws, std::uint64_t seed);

/// The best of `sets`, which are not empty, with its rivals, whether or not chance reaches its evidence.
/// `larger`: what a larger set must be ahead by.
[[nodiscard]] Decision choose(const System& system, const std::vector<WeighedSet>& sets, double larger = kLarger);

/// Gain of a set on blocks that did not fit it, as a share of what it could gain there.
struct HeldOut {
  double share = 0.0, low = 0.0;   ///< with its lower 95 % end
  double unstable = 0.0;           ///< largest difference of a coefficient between the halves, in standard errors
};
[[nodiscard]] HeldOut held_out(const Parts& parts, const std::vector<std::size_t>& members);

}  // namespace voltlap::plant
