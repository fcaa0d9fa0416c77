// SPDX-License-Identifier: Apache-2.0
// An open-circuit voltage that depends on the direction of the current: found, and made a state of the model.
#pragma once
#include <string>
#include <vector>

#include "learn/identify/circuit/circuit_fit.hpp"

namespace voltlap::plant {

struct Hysteresis {
  double size_v = 0.0;    ///< 0: none
  bool in_doubt = false;  ///< more stands between the two than a step of the resistance explains
};

/// Slow charge and slow discharge that disagree by more than `steps` steps of the resistance explain, by 5 to 100 mV on
/// the mean of three bins of SOC or more: `priors` get a hysteresis of that size, how fast a change of direction turns
/// it by what fits the runs best, and the middle of the two as knowledge of the OCV; `notes` say so. Throws InputError
/// when there are no fast currents that tell the circuit.
[[nodiscard]] Hysteresis take_hysteresis(const std::vector<MeasuredRun>& runs, double capacity_ah, double steps,
                                         FitPriors& priors, std::vector<std::string>& notes);

}  // namespace voltlap::plant
