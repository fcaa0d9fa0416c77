// SPDX-License-Identifier: Apache-2.0
// Four AMK inverters, each held against what it was asked for and against the wheels, and all four against the sequence
// in which they are switched on.
//   MST-041  |I| > I_asked + I_margin for T, at each; as inverter_watch.hpp
//   MST-072  a motor's speed stands while both wheels of its axle change theirs; as speed_watch.hpp
//   MST-068  ready to drive only with the DC link on at all four; told after 500 ms without
//   MST-070  all four have obeyed in this drive, and one no longer does
#pragma once
#include "base/persistence.hpp"
#include "master/config.hpp"
#include "master/inverter/speed_watch.hpp"
#include "master/inverter_watch.hpp"
#include "master/io.hpp"

namespace voltlap::master {

struct AmkWatchState {
  InverterWatchState each[kWheels];
  SpeedWatch speed[kWheels];
  bool asked = false;      ///< the last setpoints asked to be on
  bool was_on = false;     ///< all four, when they were asked
  bool drove = false;      ///< all four were on in this drive
  Persistence off;
  // Computed by watch_amk.
  bool disobeys = false;   ///< MST-041, MST-072
  bool dropped = false;    ///< MST-070
  bool waits = false;      ///< MST-068: not all have their DC link on
  bool late = false;       ///< for too long
};

void watch_amk(const Config& config, DriveState mode, const Input& input, AmkWatchState& state);

/// What is sent now.
void note_asked(const Output& output, Duration elapsed, AmkWatchState& state);

}  // namespace voltlap::master
