// SPDX-License-Identifier: Apache-2.0
// How far the pack's voltage falls when its current rises, from how it did: a limit in amperes is so many watts at the
// voltage that it leaves, not at the one before.
//
//   R = - sum dI dU / sum dI^2      from step to step, forgotten with a time constant of 64 steps
//   V = U - R (I_limit - I)         not below half of U: the greatest power that there is
#pragma once
#include <cstdint>

#include "master/config.hpp"
#include "master/io.hpp"

namespace voltlap::master {

struct PackSag {
  bool followed = false;       ///< the step before had a reading
  Current current{};           ///< then
  PackVoltage voltage{};
  std::int64_t squares = 0;    ///< [mA^2] sum dI^2
  std::int64_t products = 0;   ///< [mA 0.1 mV] - sum dI dU
};

/// Takes one step's reading of the pack's sensor.
void watch_pack_sag(const Input& input, PackSag& state);

/// As the currents so far have shown it, else as configured.
[[nodiscard]] Resistance pack_resistance(const Config& config, const PackSag& state);

/// The voltage that a limit of `dc` amperes leaves; the present one for less than flows now.
[[nodiscard]] PackVoltage voltage_at(const Config& config, const Input& input, PackVoltage now, Current dc,
                                     const PackSag& state);

}  // namespace voltlap::master
