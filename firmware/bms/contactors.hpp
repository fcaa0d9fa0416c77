// SPDX-License-Identifier: Apache-2.0
// The sequence of the isolation relays: idle, precharge, tractive system active, open.
#pragma once
#include "bms/state.hpp"

namespace voltlap::bms {

/// AIR- and the precharge relay close first; AIR+ follows when the DC link has reached config.precharge_ratio of the
/// measured pack voltage. A fault, an open shutdown circuit, a lost or withdrawn request opens all in the same step.
void sequence_contactors(const Config& config, Instant now, State& state);

}  // namespace voltlap::bms
