// SPDX-License-Identifier: Apache-2.0
// An open-circuit voltage that depends on the direction of the current: found, and made a state of the model.
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

/// Mean excess of slow charge and slow discharge [V] where it is that of a chemistry, 5 to 100 mV in three bins of SOC
/// or more; else 0.
[[nodiscard]] double hysteresis_excess(const std::vector<MeasuredRun>& runs, double capacity_ah);

/// Slow charge and slow discharge that disagree: `priors` get a hysteresis of that size, how fast a change of direction
/// turns it by what fits the runs best, and the middle of the two as knowledge of the OCV; `notes` say so. Returns the
/// excess [V], 0 without hysteresis. Throws InputError when there are no fast currents that tell the circuit.
[[nodiscard]] double take_hysteresis(const std::vector<MeasuredRun>& runs, double capacity_ah, FitPriors& priors,
                                     std::vector<std::string>& notes);

}  // namespace voltlap::plant
