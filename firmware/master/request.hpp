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
  bool waiting = false;  ///< was armed when the inverter missed commands, which may be for frames that were lost ...
  Instant waiting_since{};  ///< ... since then
  // Computed by request_step.
  Ratio pedal{};       ///< position behind the request, dead zone removed
  Current current{};   ///< drive positive, regeneration negative
};

/// Linear share of full travel above the dead zone: (p - z) / (1 - z), 0 below z.
[[nodiscard]] Ratio beyond_dead_zone(Ratio position, Ratio zone);

/// `elapsed`: time since the previous step, 0 at the first.
void request_step(const Config& config, const Input& input, const PedalState& pedals, DriveState mode,
                  Duration elapsed, RequestState& state);

}  // namespace voltlap::master
