// SPDX-License-Identifier: Apache-2.0
// From the pedals to a phase current that the driver asks for, before any ceiling.
#pragma once
#include "master/config.hpp"
#include "master/drive_state.hpp"
#include "master/io.hpp"
#include "master/pedals.hpp"

namespace voltlap::master {

struct RequestState {
  bool armed = false;  ///< the pedal has been seen released since torque was last forbidden
  bool waiting = false;  ///< was armed, and nothing else has happened than that the inverter missed commands ...
  Instant waiting_since{};  ///< ... since then, which may be for frames that were lost
  // Computed by request_step.
  Ratio pedal{};       ///< share of the full request
  Current current{};   ///< drive positive, regeneration negative
};

/// Linear share of full travel above the dead zone: (p - z) / (1 - z), 0 below z.
[[nodiscard]] Ratio beyond_dead_zone(Ratio position, Ratio zone);

/// The parabola through 0, `at_half` at half travel, and 1; rising for 0.25 to 0.75:
///   r(p) = (4 h - 1) p + (2 - 4 h) p^2
[[nodiscard]] Ratio request_at(Ratio travel, Ratio at_half);

/// `elapsed`: time since the previous step, 0 at the first.
void request_step(const Config& config, const Input& input, const PedalState& pedals, DriveState mode,
                  Duration elapsed, RequestState& state);

}  // namespace voltlap::master
