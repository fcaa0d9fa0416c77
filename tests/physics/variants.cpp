// SPDX-License-Identifier: Apache-2.0
#include "variants.hpp"

#include <cmath>

#include "core/axle_motors.hpp"
#include "fixtures.hpp"

namespace voltlap::plant::test {
namespace {

constexpr double kPeriod_s = 0.01;

VehicleParameters with_tabulated_cell() {
  VehicleParameters car = vtm16e();
  CellParameters& c = car.cell;
  for (CellParameterMap* map : maps_of(c)) {
    for (const double value : map->value) {
      for (const double t : c.temperature_breakpoints_c) {
        for (const double i : c.current_breakpoints_a) {
          map->table.push_back(value * (1.0 + map->per_kelvin * (t - 30.0)) * (1.0 + map->per_ampere * (i - 200.0)));
        }
      }
    }
    map->value.clear();
  }
  return car;
}

VehicleParameters with_tabulated_ocv() {
  VehicleParameters car = vtm16e();
  const CellTables tables(car.cell);
  car.cell.ocv_polynomial_v.clear();
  for (int i = 0; i <= 20; ++i) {
    car.cell.ocv_soc.push_back(i / 20.0);
    car.cell.ocv_v.push_back(tables.ocv(i / 20.0).voltage_v);
  }
  return car;
}

/// Twice the first branch's resistance, divided among `count` of different speed.
VehicleParameters with_branches(std::size_t count) {
  VehicleParameters car = vtm16e();
  const CellBranch first = car.cell.branches[0];
  car.cell.branches = {};
  for (std::size_t k = 0; k < count; ++k) {
    car.cell.branches[k] = first;
    for (double& r : car.cell.branches[k].r_ohm.value) r *= 2.0 / static_cast<double>(count);
    for (double& tau : car.cell.branches[k].tau_s.value) tau *= std::pow(6.0, static_cast<double>(k)) / 30.0;
  }
  return car;
}

template <class Change>
VehicleParameters changed(const Change& change) {
  VehicleParameters car = vtm16e();
  change(car);
  return car;
}

VehicleParameters with_front_share(double share) {
  VehicleParameters car = amk_4wd();
  car.powertrain.front_torque_share = car.powertrain.front_braking_share = share;
  return car;
}

}  // namespace

std::vector<Variant> all_variants() {
  return {
      {"24 cells", vtm16e(), false},
      {"representative cell", vtm16e(), true},
      {"two cells in parallel", changed([](auto& c) { c.battery.cells_in_parallel = 2; }), false},
      {"two cells in parallel, representative", changed([](auto& c) { c.battery.cells_in_parallel = 2; }), true},
      {"cells that differ", changed([](auto& c) {
         c.battery.cells.resize(24);
         c.battery.cells[6] = {.capacity_scale = 0.92, .resistance_scale = 1.3, .initial_soc_offset = -0.05};
       }), false},
      {"table-form cell", with_tabulated_cell(), true},
      {"tabulated OCV", with_tabulated_ocv(), true},
      {"one RC branch", with_branches(1), false},
      {"three RC branches", with_branches(3), true},
      {"four RC branches", with_branches(4), false},
      {"cold cell", changed([](auto& c) { c.battery.initial_temperature_c = 5.0; }), true},
      {"motor of efficiency 0.9", changed([](auto& c) { c.motor.efficiency = 0.9; }), true},
      {"motor with winding loss", changed([](auto& c) { c.motor.winding_loss = true; }), true},
      {"driveline of efficiency 0.9", changed([](auto& c) { c.powertrain.driveline_efficiency = 0.9; }), true},
      {"inverter of efficiency 0.95", changed([](auto& c) { c.inverter.efficiency = 0.95; }), true},
      {"all losses", lossy_vtm16e(), false},
      {"a drive of loss terms", changed([](auto& c) {
         c.motor.winding_loss = true;
         c.motor.winding_per_kelvin = 0.0039;
         c.motor.drag_hysteresis_nm = 0.8;
         c.motor.drag_eddy_nm_s = 0.002;
         c.motor.drag_windage_nm_s2 = 1e-6;
         c.motor.rotor_inertia_kg_m2 = 0.02;
         c.inverter.loss_w = 60.0;
         c.inverter.loss_w_per_a = 0.8;
         c.inverter.loss_w_per_a2 = 1e-3;
         c.inverter.loss_w_per_v_a = 5e-3;
       }), true},
      {"four hub motors", amk_4wd(), true},
      {"four hub motors, the front axle driven harder", with_front_share(0.7), false},
      {"no powertrain", changed([](auto& c) { c.powertrain.kind = "none"; }), true},
  };
}

Drive::Drive(const Variant& variant, int steps_per_period)
    : car(variant.car, variant.representative, kPeriod_s / steps_per_period), steps_(steps_per_period) {}

void Drive::switch_on() {
  car.contactors.air_minus.command(true);
  car.contactors.precharge.command(true);
  run(0.6, 0.0, 0.0);
  car.contactors.air_plus.command(true);
  run(0.1, 0.0, 0.0);
}

void Drive::run(double seconds, double phase_current_a, double brake) {
  const auto periods = std::lround(seconds / kPeriod_s);
  for (long period = 0; period < periods; ++period) {
    const VehicleParameters& p = car.parameters();
    const DrivenAxles axles = phase_current_a >= 0.0 ? driving_axles(p.powertrain) : braking_axles(p.powertrain);
    // A current for the motor of vtm16e, as the same force at the wheels.
    const double constant = 0.15 * 32.0 / 12.0;
    const double scale =
        p.powertrain.motors == 1 ? 1.0 : constant / (p.motor.constant_nm_per_a * p.powertrain.final_drive);
    for (MotorDrive& drive : car.drives) {
      drive.inverter.command(scale * (drive.front ? axles.front : axles.rear).each(phase_current_a), true);
    }
    for (int i = 0; i < steps_; ++i) car.step(brake);
    car.renew(kPeriod_s);
  }
}

void Drive::mixed() {
  run(2.0, 450.0, 0.0);
  run(0.3, 0.0, 0.0);
  run(1.0, -150.0, 0.0);
  run(1.0, 0.0, 0.5);
}

}  // namespace voltlap::plant::test
