// SPDX-License-Identifier: Apache-2.0
// A log against the model, with everything that is asked of it; and what is left of its channels when a model is
// taken as it is.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "explain/explanation.hpp"
#include "explain/fit/columns.hpp"

namespace voltlap::explain {

/// Which minutes of a log are looked at.
enum class Minutes { kAll, kEven, kOdd };

/// How a log begins: at rest or after a drive that is not in it; by itself, as its first minutes tell: beginning.hpp.
enum class Beginning { kByItself, kAtRest, kCharged };

/// How logs are held against models.
struct Holding {
  plant::ComparisonOptions compared;
  Minutes minutes = Minutes::kAll;
  Beginning beginning = Beginning::kByItself;
};

struct Held {
  plant::World world;
  Observed seen;
  std::vector<Family> members;  ///< of those that were asked for
  [[nodiscard]] const plant::Recording& log() const { return seen.comparison.log; }
};
[[nodiscard]] Held held_against(const plant::World& model, plant::Recording read, const Holding& how);

/// What a channel, or a member, leaves when where it began is all that is fitted, each block under the fit of the
/// others.
struct LeftOf {
  VectorXd squares;  ///< sum of each block
  double count = 1.0, noise = 0.0;
  std::string unit;
};
/// From one to the other, with what leaving out one block after the other makes of the change.
[[nodiscard]] plant::ChannelGain gain_of(const LeftOf& before, const LeftOf& after);
/// Of one channel of a fit.
[[nodiscard]] LeftOf left_in(const Family& family, const Fit& fit, std::size_t channel, const std::string& unit);
[[nodiscard]] std::map<std::string, LeftOf> left_of(const Observed& log);

}  // namespace voltlap::explain
