// SPDX-License-Identifier: Apache-2.0
// Whether a motor's speed stands while both wheels of its axle change theirs by 1 m/s in the same sense, for 100 ms:
// they are geared together. One wheel alone accuses its own sensor, and one sample nobody. A motor that reads nothing
// while the wheels stand agrees with them, whatever they ran at when it stopped to speak: a fault that is reset there
// stays reset.
#pragma once
#include "base/leaky_persistence.hpp"
#include "base/sample.hpp"
#include "base/units.hpp"

namespace voltlap::master {

struct SpeedWatch {
  bool started = false;
  MotorSpeed speed{};     ///< when it last changed ...
  Speed left{}, right{};  ///< ... and what the wheels ran at then
  LeakyPersistence frozen;
};

/// True once it has stood for so long.
[[nodiscard]] bool speed_stands(const Sample<MotorSpeed>& motor, const Sample<Speed>& left, const Sample<Speed>& right,
                                Instant now, SpeedWatch& state);

}  // namespace voltlap::master
