// SPDX-License-Identifier: Apache-2.0
// Rows at which the open-circuit voltage is so steep that what little is wrong with the SOC shows as a large error: of
// an empty cell, and of a full one with a flat curve elsewhere.
//
//   w -> w / (1 + ((|dOCV/ds| - 8 V) sigma_s / sigma_V)^2)        sigma_s = 0.3 % of SOC, sigma_V = 5 mV
#pragma once
#include <vector>

#include "learn/identify/circuit/circuit_model.hpp"
#include "learn/identify/recording/measured_run.hpp"

namespace voltlap::plant {

/// Takes weight from such rows; where the curve rises by less than 8 V over the whole SOC nothing changes.
void discount_steep_ends(std::vector<MeasuredRun>& runs, const CircuitModel& model);

}  // namespace voltlap::plant
