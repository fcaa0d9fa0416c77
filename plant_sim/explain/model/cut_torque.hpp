// SPDX-License-Identifier: Apache-2.0
// What a pedal asks and no motor gives: limits of the battery cut the torque, and a log of pedals does not say where.
#pragma once
#include "explain/balances/recording.hpp"
#include "explain/balances/world.hpp"

namespace voltlap::explain {

/// The recording without the accelerator where it asks for more power than the pack gave in the half minute before and
/// behind: a limit may have cut it there. The same where the motor's curve cuts and nobody read how fast it turned. One
/// with the motor's torque or current stays as it is.
[[nodiscard]] plant::Recording without_cut_torque(const plant::World& model, plant::Recording log);

}  // namespace voltlap::explain
