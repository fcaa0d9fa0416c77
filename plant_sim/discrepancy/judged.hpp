// SPDX-License-Identifier: Apache-2.0
// All that the search found out about a log, from which the verdict, its words and its numbers are made.
#pragma once
#include <vector>

#include "discrepancy/parts.hpp"
#include "discrepancy/verdict.hpp"

namespace voltlap::plant {

struct Judged {
  const std::vector<Cause>& causes;
  const Design& design;
  const std::vector<Candidate>& locals;
  const System& system;
  const NoiseModel& noise;
  const Usual& usual;
  const std::vector<bool>& use;  ///< blocks that were fitted; empty: all
  const std::vector<WeighedSet>& sets;
  const Decision& decision;
  const Parts& parts;
  const Refinery& refinery;
  const Comparison* holdout;     ///< a log that the gain is measured on; none: blocks of this one
};

/// Cause of a candidate that has one.
[[nodiscard]] inline const Cause& cause_of(const Judged& j, std::size_t member) {
  return j.causes[static_cast<std::size_t>(j.system.candidates[member].cause)];
}

}  // namespace voltlap::plant
