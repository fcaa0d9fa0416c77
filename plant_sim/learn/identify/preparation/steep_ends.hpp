// SPDX-License-Identifier: Apache-2.0
// Rows at which the open-circuit voltage is so steep that what little is wrong with the SOC shows as a large error: of
// an empty cell, and of a full one with a flat curve elsewhere.
//
//   w -> w / (1 + ((|dOCV/ds| - 8 V) sigma_s / sigma_V)^2)
//
//   sigma_s: what a quick fit misses there, as SOC; sigma_V: what it misses elsewhere
#pragma once
#include <vector>

#include "learn/identify/circuit/fitted_circuit.hpp"

namespace voltlap::plant {

/// Takes weight from such rows where a quick fit that hardly looks at them follows them far worse than the others.
void discount_steep_ends(std::vector<MeasuredRun>& runs, const FitPriors& priors);

}  // namespace voltlap::plant
