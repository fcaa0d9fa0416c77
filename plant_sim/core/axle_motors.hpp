// SPDX-License-Identifier: Apache-2.0
// Which axles have motors, and how what all of them have together is shared: front `share`, rear the rest, the two
// motors of an axle alike.
#pragma once
#include <algorithm>

#include "core/parameters.hpp"

namespace voltlap::plant {

/// Of an axle.
struct AxleMotors {
  int count = 0;
  double share = 0.0;  ///< of all motors together

  /// Of a total, what each motor of this axle has.
  [[nodiscard]] double each(double total) const { return count == 0 ? 0.0 : total * share / count; }
};

struct DrivenAxles {
  AxleMotors front, rear;
};

[[nodiscard]] inline DrivenAxles driven_axles(const PowertrainSection& p, double front_share) {
  if (p.motors == 1) return {{0, 0.0}, {1, 1.0}};
  return {{p.motors / 2, front_share}, {p.motors / 2, 1.0 - front_share}};
}
[[nodiscard]] inline DrivenAxles driving_axles(const PowertrainSection& p) {
  return driven_axles(p, p.front_torque_share);
}
[[nodiscard]] inline DrivenAxles braking_axles(const PowertrainSection& p) {
  return driven_axles(p, p.front_braking_share);
}

/// Phase current [A] of all motors at a full pedal: the largest at which none has more than its inverter's largest.
[[nodiscard]] inline double full_phase_current_a(const VehicleParameters& car) {
  if (car.powertrain.motors == 1) return car.inverter.current_max_a;
  const double front = car.powertrain.front_torque_share;
  return 0.5 * car.powertrain.motors * car.inverter.current_max_a / std::max(front, 1.0 - front);
}

}  // namespace voltlap::plant
