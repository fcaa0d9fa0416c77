// SPDX-License-Identifier: Apache-2.0
// A car whose log follows from its own forces leaves nothing in the balances; what is changed shows where it
// should.
#include "explain/balances/car_balances.hpp"

#include <cmath>
#include <random>

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double kRadius = 0.21, kGear = 3.3, kMass = 300.0, kFullTorque = 150.0, kBrakeForce = 7000.0;
constexpr double kLeft = 0.03;  // m/s: what a brake that just begins to touch is worth

World sound_car() {
  World out;
  VehicleParameters& car = out.car;
  car.vehicle.mass_kg = kMass;
  car.vehicle.cg_rear_fraction = 0.55;
  car.vehicle.wheelbase_m = 1.5;
  car.tyres.radius_m = kRadius;
  car.tyres.pacejka_b = 9.0;
  car.tyres.pacejka_c = 1.5;
  car.tyres.pacejka_d = 1.5;
  car.environment.gravity_mps2 = 9.81;
  car.powertrain.final_drive = kGear;
  car.powertrain.driveline_efficiency = 1.0;
  car.inverter.efficiency = 0.95;
  car.inverter.current_max_a = kFullTorque / 0.25;
  car.motor.constant_nm_per_a = 0.25;
  car.motor.efficiency = 1.0;
  car.motor.curve_speed_rpm = {0.0, 10000.0};
  car.motor.curve_torque_nm = {kFullTorque, kFullTorque};
  car.brakes.front_friction = 0.5;
  car.brakes.front_radius_m = 0.08;
  car.brakes.front_caliper_force_n = kBrakeForce * kRadius / (2.0 * 0.5 * 0.08);
  for (double* mass : {&car.brakes.front_rotor_mass_kg, &car.brakes.rear_rotor_mass_kg}) *mass = 1.0;
  car.brakes.rotor_heat_capacity_j_per_kg_k = 500.0;
  return out;
}

/// Speeds up and brakes again and again; `regenerated` of the braking is the motor's.
Comparison drive(double regenerated = 0.0, double torque_noise = 0.0) {
  constexpr Index kRows = 3000;
  constexpr double kStep = 0.1;
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0.0, torque_noise > 0.0 ? torque_noise : 1.0);
  Comparison out;
  Recording& log = out.log;
  log.time_s = VectorXd::LinSpaced(kRows, 0.0, kStep * (kRows - 1));
  const Eigen::ArrayXd phase = log.time_s.array() * 0.9;
  const VectorXd speed = (12.0 - 5.0 * phase.cos()).matrix(), force = kMass * (4.5 * phase.sin()).matrix();
  const VectorXd braking = (-force).cwiseMax(0.0);
  const VectorXd torque = (force.cwiseMax(0.0) - regenerated * braking) * (kRadius / kGear);
  log.signals["speed"] = speed;
  log.signals["motor_torque"] = torque;
  log.signals["accelerator"] = torque.cwiseMax(0.0) / kFullTorque;
  log.signals["brake"] = (1.0 - regenerated) / kBrakeForce * braking;
  log.signals["motor_speed"] = speed * (kGear / kRadius * 9.549297);
  const VectorXd shaft = torque.cwiseProduct(speed) * (kGear / kRadius);
  log.signals["pack_voltage"] = VectorXd::Constant(kRows, 400.0);
  log.signals["current"] = (shaft.cwiseMax(0.0) / 0.95 + shaft.cwiseMin(0.0) * 0.95) / 400.0;
  for (double& t : log.signals["motor_torque"]) t += torque_noise > 0.0 ? noise(random) : 0.0;
  out.channels = car_channels(sound_car(), log);
  return out;
}

VectorXd predicted(const char* channel, const World& world, const Comparison& on) {
  return car_prediction(channel, world, on, BatteryResponse{});
}

double largest(const VectorXd& values) {
  double out = 0.0;
  for (const double v : values) out = std::isfinite(v) ? std::max(out, std::abs(v)) : out;
  return out;
}

VectorXd residual(const char* channel, const World& world, const Comparison& on) {
  return on.find(channel)->measured - predicted(channel, world, on);
}

}  // namespace

TEST_GROUP(CarBalances){};

TEST(CarBalances, a_sound_car_gains_the_speed_that_its_forces_give) {
  const Comparison on = drive();
  CHECK(largest(on.find("speed")->measured) > 4.0);
  CHECK(largest(residual("speed", sound_car(), on)) < kLeft);
}

TEST(CarBalances, more_mass_gains_less_speed) {
  const Comparison on = drive();
  World heavy = sound_car();
  heavy.car.vehicle.mass_kg *= 1.1;
  CHECK(largest(residual("speed", heavy, on)) > 0.3);
}

TEST(CarBalances, an_unknown_brake_begins_the_gain_of_speed_anew) {
  Comparison on = drive();
  on.log.signals["brake"](1500) = std::nan("");
  on.channels = car_channels(sound_car(), on.log);
  const VectorXd left = residual("speed", sound_car(), on);
  CHECK(std::isnan(left(1500)));
  DOUBLES_EQUAL(0.0, left(1501), 0.0);
  CHECK(largest(left) < kLeft);
}

TEST(CarBalances, braking_by_the_motor_shows_in_the_torque_with_the_accelerator_released_alone) {
  const Comparison on = drive(0.2);
  CHECK(largest(residual("motor_torque", sound_car(), on)) > 5.0);
  World regenerates = sound_car();
  regenerates.regen_split = 0.2;
  CHECK(largest(residual("motor_torque", regenerates, on)) < 1e-6);
  CHECK(largest(residual("speed", sound_car(), on)) < kLeft);
}

TEST(CarBalances, a_winding_that_warms_takes_more_power) {
  const Comparison on = drive();
  World cold = sound_car();
  MotorSection& motor = cold.car.motor;
  motor.winding_loss = true;
  motor.winding_resistance_ohm = 0.02;
  motor.winding_reference_c = cold.car.environment.ambient_c;
  motor.insulation_conductance_w_per_k = motor.steel_conductance_w_per_k = 60.0;
  motor.aluminium_conductance_w_per_k = motor.convection_w_per_m2_k = 50.0;
  motor.surface_area_m2 = 0.1;
  for (double* mass : {&motor.copper_mass_kg, &motor.steel_mass_kg, &motor.aluminium_mass_kg}) *mass = 4.0;
  for (double* heat : {&motor.copper_heat_capacity_j_per_kg_k, &motor.steel_heat_capacity_j_per_kg_k,
                       &motor.aluminium_heat_capacity_j_per_kg_k})
    *heat = 400.0;
  World warm = cold;
  warm.car.motor.winding_per_kelvin = 0.0039;
  const VectorXd more = predicted("power", warm, on) - predicted("power", cold, on);
  CHECK(largest(more.head(20)) < 0.1 * largest(more.tail(200)));
  CHECK(more.minCoeff() > -1e-9 && largest(more) > 0.01);
}

TEST(CarBalances, wheels_that_begin_to_slip_take_speed_that_the_car_does_not_gain) {
  Comparison on = drive();
  World car = sound_car();
  car.car.powertrain.driveline_inertia_kg_m2 = 1.0;
  const VectorXd rolls = predicted("speed", car, on);
  const VectorXd& torque = on.log.signals.at("motor_torque");
  Index from = 1500;
  while (torque(from - 1) < 0.8 * torque.maxCoeff()) ++from;
  for (Index row = from; row < torque.size(); ++row) on.log.signals["motor_speed"](row) *= 1.1;
  const VectorXd slips = predicted("speed", car, on);
  // J / r^2 of all that is sped up, times what the wheels turn faster.
  const double kg = 1.0 / (kRadius * kRadius), faster = 0.1 * on.log.signals["speed"](from);
  DOUBLES_EQUAL(-kg / (kMass + kg) * faster, slips(from) - rolls(from), 0.02 * faster);
  DOUBLES_EQUAL(0.0, slips(from - 1) - rolls(from - 1), 1e-12);
}

TEST(CarBalances, less_grip_slips_more_near_the_limit_and_no_more_at_rest) {
  const Comparison on = drive();
  World slippery = sound_car();
  slippery.grip_change = -0.3;
  const VectorXd more = predicted("motor_speed", slippery, on) - predicted("motor_speed", sound_car(), on);
  const VectorXd& torque = on.log.signals.at("motor_torque");
  Index pulls = 0, rolls = 0;
  torque.maxCoeff(&pulls);
  torque.minCoeff(&rolls);
  CHECK(more(pulls) > 1.0);
  DOUBLES_EQUAL(0.0, more(rolls), 1e-9);
}

TEST(CarBalances, noise_of_the_torque_does_not_look_like_a_late_current) {
  const Comparison on = drive(0.0, 0.5);
  World late = sound_car();
  late.current.delay_s = 5e-3;
  const VectorXd left = residual("power", sound_car(), on);
  const VectorXd effect = predicted("power", late, on) - predicted("power", sound_car(), on);
  const double share = effect.dot(left) / effect.squaredNorm();  // of 5 ms
  DOUBLES_EQUAL(0.0, share, 4.0 * 0.4 / effect.norm());
}
