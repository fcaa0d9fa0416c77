// SPDX-License-Identifier: Apache-2.0
// The SOC that a log begins with where it does not begin with a rest: its voltage is not yet that of its charge.
#pragma once
#include "explain/balances/balances.hpp"

namespace voltlap::plant {

/// Where the log says that it does not begin with a rest, or where it is far better explained so: a car that rolls for
/// seconds amid its drive draws as little as one after a night. Then the log's own SOC is taken, or the one with which
/// the model is right in the first minute; and what was drawn before as what is drawn in the first minutes, where that
/// explains the log better than a cell that had rested until then. `cells`: in series, of the first channel.
void settle_start_under_load(const World& model, double cells, Comparison& comparison);

}  // namespace voltlap::plant
