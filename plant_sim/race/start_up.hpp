// SPDX-License-Identifier: Apache-2.0
// From low voltage over the active tractive system to ready to drive, as the rules' procedure asks (EV.9): which
// buttons the driver presses, and how long it may take.
#pragma once
#include "can_dbc/car.hpp"
#include "core/demand.hpp"
#include "race/sensors/sensor_frames.hpp"

namespace voltlap::plant {

class StartUp {
 public:
  static constexpr double kLongest_s = 20.0;  ///< beyond it the run counts as failed

  /// The buttons in a tick of `tick_s` that begins `time_s` after power-on, by what the BMS last said.
  void press(double time_s, double tick_s, can::BmsState bms, Switches& switches) {
    VOLTLAP_DEMAND(tick_s > 0.0 && time_s >= 0.0);
    const bool active = bms == can::BmsState::kTsActive;
    switches.ts_on = !active && time_s >= kTsButton_s;
    active_s_ = active ? active_s_ + tick_s : 0.0;
    switches.ready_to_drive = active_s_ >= kReadyButton_s;
  }

 private:
  static constexpr double kTsButton_s = 0.5;     // after power-on: every ECU has heard every sensor
  static constexpr double kReadyButton_s = 2.0;  // after the contactors closed: the limits have risen

  double active_s_ = 0.0;
};

}  // namespace voltlap::plant
