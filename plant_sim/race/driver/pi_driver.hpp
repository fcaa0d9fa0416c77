// SPDX-License-Identifier: Apache-2.0
// The driver: two PI controllers, one for the accelerator and one for the brake; which one acts follows from the
// target's slope (reference study, 2016, section 4.2, Fig. 4.5).
//
//   pedal = base + Kp e + Ki integral(e), e = target - speed (brake: the negative), 0..1
// The integral is kept only while the pedal is inside its range (anti-windup), and starts anew with every event.
//
// Who is slower than the target has nothing to brake for: in a braking zone a car that lags by kBehind_mps drives on
// until it meets the target again. So the driver never stalls, wherever on the course the car stands. On a road, who is
// kAhead_mps too fast brakes whatever the target does next, nobody brakes for a target that slows down more gently than
// the car does by itself, and neither pedal goes beyond what the tyres hold.
#pragma once
#include <algorithm>
#include <cmath>

#include "core/demand.hpp"
#include "core/parameters.hpp"
#include "race/driver/road_sense.hpp"
#include "race/driver/target.hpp"

namespace voltlap::plant {

struct Pedals {
  double accelerator = 0.0;  ///< 0..1
  double brake = 0.0;        ///< 0..1
};

class PiDriver {
 public:
  explicit PiDriver(const DriverSection& driver) : driver_(driver) {}

  Pedals advance(const Target& target, double speed_mps, double step_s, const RoadSense& road = {}) {
    VOLTLAP_DEMAND(std::isfinite(target.speed_mps) && std::isfinite(speed_mps) && step_s > 0.0);
    const double error = target.speed_mps - speed_mps;
    catching_up_ = catching_up_ ? error > 0.0 : error > kBehind_mps;
    too_fast_ = road.follows_road && (too_fast_ ? error < 0.0 : error < -kAhead_mps);
    const double brake_below = std::min(driver_.brake_below_mps2, road.coasting_mps2);
    const bool brakes = (target.slope_mps2 < brake_below && !catching_up_) || too_fast_;
    if (brakes != braking_) {
      braking_ = brakes;
      integral_m_ = 0.0;
    }
    if (brakes) {
      const double pedal = follow(target.brake_base, -error, driver_.brake_gain_per_mps,
                                  driver_.brake_integral_per_m, step_s);
      return {0.0, std::min(pedal, road.brake_most)};
    }
    const double pedal = follow(target.accelerator_base, error, driver_.accelerator_gain_per_mps,
                                driver_.accelerator_integral_per_m, step_s);
    return {std::min(pedal, road.accelerator_most), 0.0};
  }

 private:
  static constexpr double kBehind_mps = 1.0;  // far more than a driver who brakes well is ever slower than the target
  static constexpr double kAhead_mps = 0.15;

  double follow(double base, double error, double gain, double integral_gain, double step_s) {
    const double next = integral_m_ + error * step_s;
    const double pedal = base + gain * error + integral_gain * next;
    const bool winds_up = (pedal > 1.0 && error > 0.0) || (pedal < 0.0 && error < 0.0);
    if (!winds_up) integral_m_ = next;
    return std::clamp(pedal, 0.0, 1.0);
  }

  DriverSection driver_;
  bool braking_ = false, catching_up_ = false, too_fast_ = false;
  double integral_m_ = 0.0;
};

}  // namespace voltlap::plant
