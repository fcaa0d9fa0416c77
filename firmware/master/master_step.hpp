// SPDX-License-Identifier: Apache-2.0
// One step of the master controller, 100 Hz: the stages in order.
#pragma once
#include "master/arbitration.hpp"
#include "master/drive_state.hpp"
#include "master/inverter/amk_watch.hpp"
#include "master/inverter/pm100_watch.hpp"
#include "master/inverter_watch.hpp"
#include "master/pedals.hpp"
#include "master/request.hpp"

namespace voltlap::master {

/// All-zero memory is a controller that has not started.
struct State {
  bool started = false;
  Instant last_step{};
  PedalState pedals;
  DriveStateState drive;
  RequestState request;
  ArbitrationState arbitration;
  InverterWatchState inverter_watch;
  SpeedWatch speed_watch;  ///< of an inverter with frames of ours; the others have their own
  Pm100WatchState pm100_watch;
  InverterDropState inverter_drop;
  AmkWatchState amk_watch;
};

/// Longest time between two steps that rate limits give credit for.
inline constexpr Duration kStepMax = Duration::from_ms(20);

[[nodiscard]] Output step(const Config& config, const Input& input, State& state);

}  // namespace voltlap::master
