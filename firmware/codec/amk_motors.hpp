// SPDX-License-Identifier: Apache-2.0
// Speed and torque current of four motors as their AMK inverters tell them, and what stands for all four. What is said
// of all is as old as the oldest of its parts, and good only while every part is.
#pragma once
#include "base/sample.hpp"
#include "base/units.hpp"
#include "codec/amk_frames.hpp"
#include "codec/refresh.hpp"

namespace voltlap::codec {

/// Front left, front right, rear left, rear right.
struct AmkMotors {
  Sample<MotorSpeed> speed[kWheels];
  Sample<Current> current[kWheels];
};

inline void take_motor(const AmkActual1& m, std::size_t wheel, Instant now, AmkMotors& motors) {
  refresh(motors.speed[wheel], m.actual_velocity_ok, MotorSpeed::from_raw(m.actual_velocity_rpm), now);
  refresh(motors.current[wheel], true, Current::from_raw(amk_current_ma(m.torque_current)), now);
}

inline void expire_motors(AmkMotors& motors, Instant now) {
  for (std::size_t k = 0; k < kWheels; ++k) {
    expire(motors.speed[k], AmkActual1::kTimeoutMs, now);
    expire(motors.current[k], AmkActual1::kTimeoutMs, now);
  }
}

/// `join` makes one value of two.
template <class T, class Join>
[[nodiscard]] Sample<T> joined(const Sample<T> (&parts)[kWheels], Instant now, Join join) {
  Sample<T> out = parts[0];
  for (std::size_t k = 1; k < kWheels; ++k) {
    if ((now - parts[k].time).ms() > (now - out.time).ms()) out.time = parts[k].time;
    if (!parts[k].good()) out.quality = parts[k].quality;
    out.value = join(out.value, parts[k].value);
  }
  return out;
}

[[nodiscard]] inline Sample<Current> current_of_all(const AmkMotors& motors, Instant now) {
  return joined(motors.current, now, [](Current a, Current b) { return a + b; });
}

/// The fastest in either direction: of four wheels it has the least left of every limit.
[[nodiscard]] inline Sample<MotorSpeed> fastest(const AmkMotors& motors, Instant now) {
  return joined(motors.speed, now, [](MotorSpeed a, MotorSpeed b) {
    const std::int64_t size_a = a.raw() < 0 ? -std::int64_t{a.raw()} : a.raw();
    const std::int64_t size_b = b.raw() < 0 ? -std::int64_t{b.raw()} : b.raw();
    return size_b > size_a ? b : a;
  });
}

}  // namespace voltlap::codec
