// SPDX-License-Identifier: Apache-2.0
// What of the battery's power arrives at the shaft, as measured while a ceiling holds the torque, and the two windows
// of the 80 kW rule.
//
//   eta = K |omega| I_asked / (V I_dc)        measured where both are of the same step and the command has been steady
//
// It falls within some 40 ms and rises within half a second: too low costs time, too high costs the event. What was
// asked for counts, not what the inverter says of it: the ceiling that follows is asked for, too, and a wrong motor
// constant or scale of the inverter's report is in both.
#pragma once
#include <cstdint>

#include "master/config.hpp"
#include "master/io.hpp"

namespace voltlap::master {

struct DrivePower {
  Ratio efficiency{};        ///< 0: never measured
  Current asked_before{};
  Duration steady{};         ///< for how long what is asked for has hardly moved
  MotorSpeed speed[2] = {};  ///< of the last step and of the one before
  // MST-037
  static constexpr std::size_t kSteps = 50;  ///< 500 ms
  std::int32_t power_mw[kSteps] = {};
  std::int64_t sum_mw = 0;
  std::uint8_t next = 0;
  Duration above{};          ///< for how long 80 kW have been exceeded without a break
  Current held{};            ///< what flowed when a window was about to be broken; 0: none is
};

/// Takes one step's measurements. `asked` is the phase current of the last step, `at_ceiling` whether the battery's
/// limit or the power limit held it.
void watch_drive_power(const Config& config, const Input& input, Current asked, bool at_ceiling, Duration elapsed,
                       DrivePower& state);

/// Shaft power over DC power; the configuration's low estimate until it was measured and where it cannot be.
[[nodiscard]] Ratio drive_efficiency(const Config& config, const Input& input, const DrivePower& state);

/// The speed at which the next command acts, as the last two steps go on: not below the present one, in magnitude.
[[nodiscard]] MotorSpeed speed_ahead(MotorSpeed now, const DrivePower& state);

/// Share of a ceiling that the windows of the rule leave: 1'000'000 but where one is about to be broken.
[[nodiscard]] Ratio window_share(const DrivePower& state);

/// Rounded towards zero.
[[nodiscard]] Current share_of(Current current, Ratio share);

/// That of what flowed then, too: a ceiling that rests on a speed that lies may be far above it.
[[nodiscard]] Current within_windows(Current ceiling, const DrivePower& state);

}  // namespace voltlap::master
