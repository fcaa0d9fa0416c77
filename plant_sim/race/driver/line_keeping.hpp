// SPDX-License-Identifier: Apache-2.0
// The car beside the line of its course, and the driver who steers it along. Who is slow enough is on the line; who is
// faster than the grip allows runs wide, on a longer way, until grip is left to come back.
//
//   s' = v cos(psi) / (1 - kappa n)     n' = v sin(psi)     psi' = a_y / v - kappa s'
//   asked: a_y = v^2 kappa / (1 - kappa n) - w^2 n - 2 w v sin(psi)
//   u = |v^2 kappa| over what tyres and wheel loads allow; above 1 the steering is opened to 1/u of it, and a little
//   for who is faster than planned, which leaves grip to brake with
// s: along the line; n: beside it, to the right; psi: heading against it; kappa > 0 turns right.
#pragma once
#include "core/parameters.hpp"

#include "car/vehicle/longitudinal.hpp"
#include "race/driver/target.hpp"

namespace voltlap::plant {

class LineKeeping {
 public:
  explicit LineKeeping(const VehicleParameters& car) : car_(car) {}

  /// The target of a driver who sees how far outside of the line the car is: slower, until there is grip to return.
  [[nodiscard]] Target eased(Target target) const;
  /// What the road asks of the car here, at its speed.
  [[nodiscard]] Road road(const Target& target, double speed_mps);
  /// The car went `way_m` in `step_s` on the road that `road` gave last.
  void advance(double way_m, double step_s);

  [[nodiscard]] double distance_m() const { return distance_; }  ///< along the line
  [[nodiscard]] double offset_m() const { return offset_; }      ///< positive to the right of it

 private:
  [[nodiscard]] double asked(double speed_mps, double curvature_per_m) const;

  const VehicleParameters& car_;
  double distance_ = 0.0, offset_ = 0.0, heading_ = 0.0;
  double curvature_ = 0.0, lateral_ = 0.0;
  bool slides_ = false;  ///< the tyres give less than is asked
};

}  // namespace voltlap::plant
