// SPDX-License-Identifier: Apache-2.0
#include "race/driver/road_sense.hpp"

#include <algorithm>

#include "car/powertrain/driveline.hpp"
#include "car/powertrain/motor.hpp"
#include "car/vehicle/aero.hpp"
#include "car/vehicle/cornering.hpp"
#include "car/vehicle/grip.hpp"
#include "car/vehicle/rolling_resistance.hpp"
#include "core/demand.hpp"

namespace voltlap::plant {
namespace {

constexpr double kBelowTheEdge = 0.99;  // of the grip; assumed

}  // namespace

RoadSense feel_road(const VehicleParameters& car, const Road& road, double speed_mps) {
  const double airspeed = speed_mps + road.head_wind_mps;
  const double resistance = drag_force(car, airspeed) + rolling_force(car, speed_mps) +
                            cornering_drag(car, road.lateral_mps2) + climbing_force(car, road.grade);
  const double share = kBelowTheEdge * road.longitudinal_share;
  const double radius = car.tyres.radius_m;
  const CoastingDrag coasting = coasting_drag(car, speed_mps, radius);
  const double full = wheel_torque(car.powertrain, motor_torque(car.motor, full_phase_current_a(car), 1.0), true) /
                      radius;
  const double drag_nm =
      car.powertrain.motors * motor_drag(car.motor, speed_mps / radius * car.powertrain.final_drive);
  const double drag = wheel_torque(car.powertrain, drag_nm, true) / radius;  // that a driving current makes up for
  RoadSense sense{true, 1.0, locking_pedal(car, airspeed, share, resistance, radius, coasting),
                  -(resistance + coasting.sum_n()) / total_mass(car)};
  if (full > 0.0) sense.accelerator_most = std::min(1.0, (drive_grip(car, airspeed, share, resistance) + drag) / full);
  VOLTLAP_DEMAND(within(sense.accelerator_most, 0.0, 1.0) && within(sense.brake_most, 0.0, 1.0));
  return sense;
}

}  // namespace voltlap::plant
