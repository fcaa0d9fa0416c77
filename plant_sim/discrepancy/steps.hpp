// SPDX-License-Identifier: Apache-2.0
// What coarse steps of the current let one believe: noise of its readings, and causes that follow from it.
#pragma once
#include "discrepancy/cause.hpp"
#include "discrepancy/design.hpp"
#include "discrepancy/score.hpp"

namespace voltlap::plant {

/// Steps that no reference knows put `deviation_a` into the readings (integrity.hpp: coarser_by_a). They are noise i of
/// the voltage behind them (noise.hpp), and allowed for, from log to log, where they look like a cause (Cause::seeming):
///   current_offset   i                              a reading stays on one side of its step
///   auxiliary_load   i U                            so does the current at standstill
///   time_skew        dt i^2 / mean((I_k - I_k-1)^2)   of the current: its noise stands in the signature too
void allow_for_steps(double deviation_a, const std::vector<Cause>& causes, Design& design, NoiseModel& noise);

}  // namespace voltlap::plant
