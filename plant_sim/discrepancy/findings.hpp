// SPDX-License-Identifier: Apache-2.0
// From a decision to what a person reads: verdict, causes with size and interval, gain on blocks that were kept back,
// rivals and why they lost, the test that would tell.
#pragma once
#include "discrepancy/explain.hpp"
#include "discrepancy/verdict.hpp"

namespace voltlap::plant {

struct Judged {
  const std::vector<Cause>& causes;
  const Design& design;
  const System& system;
  const NoiseModel& noise;
  const std::vector<bool>& use;  ///< blocks that were fitted; empty: all
  const std::vector<WeighedSet>& sets;
  const Decision& decision;
  const std::vector<System>&quarters, &halves;
  const Refinery& refinery;
};

/// Completes the explanation; `gate` are the causes that the integrity gate found.
void put_verdict(const Judged& judged, const std::vector<FoundCause>& gate, Explanation& out);

}  // namespace voltlap::plant
