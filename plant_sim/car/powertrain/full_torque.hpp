// SPDX-License-Identifier: Apache-2.0
// The shaft torque of a full pedal over the motor's speed, of all motors together: what the road's motors give, with
// the pack as it is at the start. Smallest of what the current makes less the drag, what the motor's curve allows at
// the bus voltage, and what the power limit and the pack can feed. Each motor has its axle's share.
#pragma once
#include <vector>

#include "core/parameters.hpp"

namespace voltlap::plant {

class FullTorque {
 public:
  explicit FullTorque(const VehicleParameters& car);

  /// [Nm] at a motor speed [rad/s] from 0 up; beyond the motor's last speed the drag alone.
  [[nodiscard]] double torque_nm(double omega_rad_s) const {
    const double place = omega_rad_s * points_per_speed_;
    const auto last = static_cast<double>(torque_nm_.size() - 1);
    if (place >= last) return beyond_nm_;
    const auto i = static_cast<std::size_t>(place);
    return torque_nm_[i] + (torque_nm_[i + 1] - torque_nm_[i]) * (place - static_cast<double>(i));
  }

  /// Power [W] that the pack may give: the power limit, the BMS's current, the cells' lowest voltage.
  [[nodiscard]] double bus_power_max_w() const { return bus_power_max_w_; }

 private:
  double points_per_speed_ = 0.0, beyond_nm_ = 0.0, bus_power_max_w_ = 0.0;
  std::vector<double> torque_nm_;
};

}  // namespace voltlap::plant
