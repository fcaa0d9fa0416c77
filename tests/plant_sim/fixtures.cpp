// SPDX-License-Identifier: Apache-2.0
#include "fixtures.hpp"

#include <filesystem>
#include <fstream>

#include <unistd.h>

namespace voltlap::plant::test {
namespace {

CellParameters aesc_e5_2p() {
  CellParameters c;
  c.name = "aesc_e5_2p";
  c.capacity_ah = 55.2;
  c.mass_kg = 1.9;
  c.heat_capacity_j_per_kg_k = 747.0;
  c.surface_area_m2 = 0.152;
  c.convection_w_per_m2_k = 7.0;
  c.reference_temperature_c = 30.0;
  c.reference_current_a = 200.0;
  c.soc_breakpoints = {0.001, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.85, 0.9, 0.95, 1.0};
  c.temperature_breakpoints_c = {22.0, 30.0, 40.0};
  c.current_breakpoints_a = {35.0, 100.0, 200.0, 300.0, 400.0};
  c.ocv_polynomial_v = {3.00, 5.98, -14.1, 15.2, -6.79, 0.88};
  const auto for_all_soc = [&](double value) { return std::vector<double>(c.soc_breakpoints.size(), value); };
  c.r0_ohm = {for_all_soc(0.0012), -0.014, -0.00034, {}};
  c.r1_ohm = {for_all_soc(0.0004), -0.019, -0.0021, {}};
  c.r2_ohm = {for_all_soc(0.0008), -0.014, -0.000019, {}};
  c.tau1_s = {{96.0, 96.0, 96.0, 92.06, 88.13, 84.19, 80.25, 72.38, 64.5, 56.63, 48.75, 40.88, 36.94, 33.0, 33.0, 33.0},
              -0.014, -0.0023, {}};
  c.tau2_s = {{1072.0, 1072.0, 1072.0, 1015.06, 958.13, 901.19, 844.25, 730.38, 616.5, 502.63, 388.75, 274.88, 217.94,
               161.0, 161.0, 161.0}, -0.012, -0.0027, {}};
  return c;
}

MotorSection motor() {
  MotorSection m;
  m.constant_nm_per_a = 0.15;
  m.efficiency = 1.0;
  m.winding_resistance_ohm = 0.0063;
  m.curve_speed_rpm = {0, 500, 1000, 1500, 2000, 2500, 3000, 3500, 4000, 4500,
                       5000, 5500, 6000, 6500, 7000, 7500, 8000, 8500, 9000, 9010};
  m.curve_torque_nm = {82, 81.8, 81.5, 81.3, 81, 80.8, 80.5, 80.3, 80, 79,
                       74, 68.8, 63, 58.2, 54, 50.4, 47.2, 44.4, 42, 0};
  m.convection_w_per_m2_k = 25.0;
  m.surface_area_m2 = 0.14;
  m.copper_mass_kg = 6.0;
  m.steel_mass_kg = 7.0;
  m.aluminium_mass_kg = 2.0;
  m.copper_heat_capacity_j_per_kg_k = 390.0;
  m.steel_heat_capacity_j_per_kg_k = 470.0;
  m.aluminium_heat_capacity_j_per_kg_k = 910.0;
  m.insulation_conductance_w_per_k = 7.2;
  m.steel_conductance_w_per_k = 1176.0;
  m.aluminium_conductance_w_per_k = 6406.0;
  return m;
}

}  // namespace

VehicleParameters vtm16e() {
  VehicleParameters p;
  p.name = "vtm16e";
  p.vehicle = {.mass_kg = 243.0, .driver_mass_kg = 72.0, .wheelbase_m = 1.54, .track_front_m = 1.18,
               .track_rear_m = 1.19, .cg_height_m = 0.33, .cg_rear_fraction = 0.52, .front_axle_inertia_kg_m2 = 0.2};
  p.tyres = {.radius_m = 0.22225, .lap_radius_m = 0.22, .friction = 1.5, .rolling_resistance = 0.01,
             .pacejka_b = 11.0947, .pacejka_c = 1.5221, .pacejka_d = 1.5, .pacejka_e = -0.0511,
             .slip_speed_floor_mps = 0.5};
  p.brakes = {.front_friction = 0.55, .rear_friction = 0.45, .front_radius_m = 0.081, .rear_radius_m = 0.056,
              .front_caliper_force_n = 5000.0, .rear_caliper_force_n = 4100.0, .force_scale = 1.0,
              .front_rotor_mass_kg = 0.346, .rear_rotor_mass_kg = 0.217, .rotor_heat_capacity_j_per_kg_k = 507.0,
              .front_rotor_area_m2 = 0.2, .rear_rotor_area_m2 = 0.2, .convection_w_per_m2_k = 80.0,
              .full_pedal_pressure_bar = 70.0};
  p.aero = {.drag_coefficient = 3.1, .downforce_coefficient = 0.014, .frontal_area_m2 = 0.12};
  p.driver = {.accelerator_gain_per_mps = 10.0, .accelerator_integral_per_m = 1.0, .brake_gain_per_mps = 40.0,
              .brake_integral_per_m = 1.0, .accelerate_pedal = 0.8, .brake_pedal = 0.9, .corner_pedal = 0.18,
              .brake_below_mps2 = -0.2};
  p.powertrain = {.kind = "electric", .final_drive = 32.0 / 12.0, .driveline_efficiency = 1.0,
                  .driveline_inertia_kg_m2 = 0.632};
  p.inverter = {.efficiency = 1.0, .current_max_a = 550.0, .command_timeout_s = 0.05, .dc_voltage_min_v = 40.0};
  p.motor = motor();
  p.cell = aesc_e5_2p();
  p.battery.cell = p.cell.name;
  p.battery.cells_in_series = 24;
  p.battery.cells_in_parallel = 1;
  p.battery.capacity_ah = p.cell.capacity_ah;
  p.battery.convection_w_per_m2_k = p.cell.convection_w_per_m2_k;
  p.battery.initial_temperature_c = 26.85;
  p.battery.lookup_current_floor_a = 5.0;
  p.contactors = {.resistance_ohm = 0.0005, .precharge_resistance_ohm = 100.0, .dc_link_capacitance_f = 0.001,
                  .bleed_resistance_ohm = 4700.0, .close_time_s = 0.02, .open_time_s = 0.01};
  p.low_voltage.power_w = 575.0;
  p.sensors = {.noise = false, .quantisation = false, .temperature_count = 6, .cell_noise_v = 0.0015,
               .cell_step_v = 0.0015, .current_low_range_a = 75.0, .current_low_noise_a = 0.1,
               .current_high_noise_a = 1.0, .current_low_step_a = 0.1, .current_high_step_a = 1.0,
               .temperature_noise_k = 0.1, .temperature_step_k = 1.0};
  p.environment = {.ambient_c = 26.85, .air_density_kg_per_m3 = 1.225, .gravity_mps2 = 9.81};
  p.bms = {.discharge_current_max_a = 600.0, .charge_current_max_a = 100.0, .temperature_max_c = 60.0,
           .resistance_ohm = 0.0, .capacity_ah = 0.0};
  p.assertions = {.speed_error_max_mps = 10.0, .battery_temperature_max_c = 50.0, .motor_temperature_max_c = 180.0};
  return p;
}

VehicleParameters lossy_vtm16e() {
  VehicleParameters p = vtm16e();
  p.motor.efficiency = 0.9;
  p.motor.winding_loss = true;
  p.powertrain.driveline_efficiency = 0.9;
  p.inverter.efficiency = 0.95;
  return p;
}

CellParameters constant_cell() {
  CellParameters c = aesc_e5_2p();
  c.name = "constant";
  c.soc_breakpoints = {0.5};
  c.temperature_breakpoints_c = {30.0};
  c.current_breakpoints_a = {100.0};
  c.ocv_polynomial_v = {3.7};
  c.r0_ohm = {{0.0012}, 0.0, 0.0, {}};
  c.r1_ohm = {{0.0004}, 0.0, 0.0, {}};
  c.r2_ohm = {{0.0008}, 0.0, 0.0, {}};
  c.tau1_s = {{33.0}, 0.0, 0.0, {}};
  c.tau2_s = {{161.0}, 0.0, 0.0, {}};
  return c;
}

Track michigan(int year) {
  return load_track(std::string(VOLTLAP_DATA_DIR "/tracks/michigan_") + std::to_string(year) + ".csv");
}

TemporaryFile::TemporaryFile(const std::string& name, const std::string& text)
    : path_((std::filesystem::temp_directory_path() / ("voltlap_" + std::to_string(::getpid()) + "_" + name)).string()) {
  std::ofstream(path_) << text;
}

TemporaryFile::~TemporaryFile() { std::filesystem::remove(path_); }

}  // namespace voltlap::plant::test
