// SPDX-License-Identifier: Apache-2.0
#include "car/vehicle/longitudinal.hpp"

#include <cmath>

#include "car/powertrain/driveline.hpp"
#include "car/vehicle/aero.hpp"
#include "car/vehicle/cornering.hpp"
#include "car/vehicle/rolling_resistance.hpp"
#include "core/demand.hpp"

namespace voltlap::plant {

VehicleEnergy LongitudinalVehicle::advance(const AxleTorques& drive, double brake_pedal, double step_s) {
  const double airspeed = speed_ + road_.head_wind_mps;
  const AxleLoads loads = axle_loads(car_, acceleration_, airspeed);
  const BrakeTorques brakes = brake_torques(car_.brakes, brake_pedal);
  const double front_inertia = front_axle_inertia(car_);
  const double rear_inertia = driveline_inertia(car_);
  const double front_n = loads.front_n * road_.longitudinal_share, rear_n = loads.rear_n * road_.longitudinal_share;
  const AxleStep front =
      axle_step(car_.tyres, {speed_, front_n, drive.front_nm, brakes.front_nm, front_inertia}, front_omega_, step_s);
  const AxleStep rear =
      axle_step(car_.tyres, {speed_, rear_n, drive.rear_nm, brakes.rear_nm, rear_inertia}, rear_omega_, step_s);

  const double drag = drag_force(car_, airspeed);
  const double rolling = rolling_force(car_, speed_);
  const double mass = total_mass(car_);
  const double cornering = cornering_drag(car_, road_.lateral_mps2);
  const double climb = climbing_force(car_, road_.grade);
  acceleration_ = (front.force_n + rear.force_n - drag - rolling - (cornering + climb)) / mass;
  const double next_speed = speed_ + acceleration_ * step_s;
  const double mean_speed = 0.5 * (speed_ + next_speed);
  const double way = mean_speed * step_s;

  VehicleEnergy e;
  e.driveline_in_j = (drive.front_nm * front.omega_mean_rad_s + drive.rear_nm * rear.omega_mean_rad_s) * step_s;
  e.kinetic_j = 0.5 * mass * (next_speed * next_speed - speed_ * speed_) +
                0.5 * front_inertia * (front.omega_rad_s * front.omega_rad_s - front_omega_ * front_omega_) +
                0.5 * rear_inertia * (rear.omega_rad_s * rear.omega_rad_s - rear_omega_ * rear_omega_);
  e.climb_j = climb * way;
  e.aero_j = drag * way;
  e.rolling_j = rolling * way;
  e.cornering_j = cornering * way;
  e.slip_j = (front.force_n * front.omega_mean_rad_s + rear.force_n * rear.omega_mean_rad_s) * car_.tyres.radius_m *
                 step_s - (front.force_n + rear.force_n) * way;
  e.front_brake_j = front.brake_torque_nm * front.omega_mean_rad_s * step_s;
  e.rear_brake_j = rear.brake_torque_nm * rear.omega_mean_rad_s * step_s;

  speed_ = next_speed;
  distance_ += way;
  front_omega_ = front.omega_rad_s;
  rear_omega_ = rear.omega_rad_s;
  front_omega_mean_ = front.omega_mean_rad_s;
  rear_omega_mean_ = rear.omega_mean_rad_s;
  return e;
}

void LongitudinalVehicle::set_road(const Road& road) {
  VOLTLAP_DEMAND(std::isfinite(road.lateral_mps2) && within(road.longitudinal_share, 0.0, 1.0));
  VOLTLAP_DEMAND(std::isfinite(road.grade) && std::isfinite(road.head_wind_mps));
  road_ = road;
}

void LongitudinalVehicle::set_speed(double speed_mps) {
  VOLTLAP_DEMAND(std::isfinite(speed_mps));
  speed_ = speed_mps;
  front_omega_ = rear_omega_ = front_omega_mean_ = rear_omega_mean_ = speed_mps / car_.tyres.radius_m;
}

}  // namespace voltlap::plant
