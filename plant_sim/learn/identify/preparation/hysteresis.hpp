// SPDX-License-Identifier: Apache-2.0
// An open-circuit voltage that depends on the direction of the current: found, and kept out of the circuit.
#pragma once
#include <string>
#include <vector>

#include "learn/identify/circuit/circuit_fit.hpp"

namespace voltlap::plant {

/// Half of what remains between slow charge and slow discharge at the same SOC when the circuit's own drop is taken
/// off [V], by SOC: an open-circuit voltage that depends on the direction. Empty when the recordings do not tell.
struct HysteresisPoint {
  double soc, middle_v, half_gap_v, excess_v;
};
[[nodiscard]] std::vector<HysteresisPoint> hysteresis_of(const std::vector<MeasuredRun>& runs, double capacity_ah);

/// Slow charge and slow discharge that disagree: the rows say nothing about the circuit, their middle is the OCV. Takes
/// the weight of those rows in `runs`, adds the middle to `priors` and says so in `notes`; returns the excess [V], 0
/// without hysteresis. Throws InputError when too little is left.
[[nodiscard]] double set_hysteresis_aside(std::vector<MeasuredRun>& runs, double capacity_ah, FitPriors& priors,
                                          std::vector<std::string>& notes);

}  // namespace voltlap::plant
