// SPDX-License-Identifier: Apache-2.0
// MST-066: a PM100 whose frames prove nothing by themselves is held against the other channels of the car.
//   frozen   the motor speed stands while both driven wheels change theirs: speed_watch.hpp
//   astray   |I_dc - I_pack| > 30 A + 30 % of the larger for 1 s, ready to drive; on a charger the two are not the same
#pragma once
#include "base/leaky_persistence.hpp"
#include "master/inverter/speed_watch.hpp"
#include "master/io.hpp"

namespace voltlap::master {

struct Pm100WatchState {
  SpeedWatch speed;
  LeakyPersistence astray;
  bool implausible = false;
};

void watch_pm100(bool ready_to_drive, const Input& input, Pm100WatchState& state);

/// MST-065: enabled once in this drive, and then locked out, timed out or no longer heard.
struct InverterDropState {
  bool enabled = false;
  bool dropped = false;
};
void watch_dropping(bool ready_to_drive, const Input& input, InverterDropState& state);

}  // namespace voltlap::master
