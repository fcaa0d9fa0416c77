// SPDX-License-Identifier: Apache-2.0
// Every number of a car, as plain data in SI units. The comment behind a field is its range and its key in the TOML
// files and in `--set`; the section is the struct's member name in VehicleParameters.
#pragma once
#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "core/firmware_parameters.hpp"
#include "core/instrument_parameters.hpp"

namespace voltlap::plant {

/// A battery parameter over SOC, temperature and current: either a full table, or a curve over SOC about a reference
/// point (then `table` is empty) with a relative change per kelvin and per ampere, Arrhenius' law, and for R0 a charge
/// transfer (car/battery/cell_tables.hpp).
struct CellParameterMap {
  std::vector<double> value;       ///< by SOC breakpoint, at the reference point
  double per_kelvin = 0.0;         ///< [1/K] relative change of the value
  double per_ampere = 0.0;         ///< [1/A] relative change of the value
  std::vector<double> table;       ///< [soc][temperature][current], last index fastest; empty: use `value`
  double activation_energy_j_per_mol = 0.0;  ///< [J/mol] the value falls with temperature by Arrhenius
  double exchange_current_a = 0.0;           ///< [A] of R0: a charge transfer besides the value; 0: none
  double exchange_activation_energy_j_per_mol = 0.0;  ///< [J/mol] by which it grows with temperature
};

inline constexpr std::size_t kMostCellBranches = 4;

/// One RC branch of a cell.
struct CellBranch {
  CellParameterMap r_ohm;  ///< [ohm] > 0
  CellParameterMap tau_s;  ///< [s] > 0

  [[nodiscard]] bool is_there() const {
    return !(r_ohm.value.empty() && r_ohm.table.empty() && tau_s.value.empty() && tau_s.table.empty());
  }
};

/// What a cell does beyond its branches and tables (equations: car/battery/cell_effects.hpp). Each is off at 0.
struct CellEffects {
  double series_ohm = 0.0;               ///< [ohm] -1..1 effects.series_ohm, added to R0
  double activation_energy_j_per_mol = 0.0;  ///< [J/mol] -60000..60000, of all resistances, beyond what the tables say
  double low_end_change = 0.0;           ///< [1] -0.9..20, of all resistances at SOC 0, fading to none at SOC 0.3
  double exchange_current_change = 0.0;  ///< [1] -0.9..20, of the charge transfer that bends R0
  std::vector<double> ocv_change_v;      ///< [V] -1..1, added to the OCV at equal steps of SOC from 0 to 1
  double polarization_ohm = 0.0;         ///< [ohm] -1..1, of a branch more
  double polarization_tau_s = 10.0;      ///< [s] 0.01..1e5
  double slow_relaxation_ohm = 0.0;      ///< [ohm] -1..1, of a slow branch more
  double slow_relaxation_tau_s = 600.0;  ///< [s] 0.01..1e5
  double hysteresis_v = 0.0;             ///< [V] -0.5..0.5, between rest after charge or discharge and the OCV
  double hysteresis_per_soc = 20.0;      ///< [1] 0.1..1000, how fast a change of direction turns it
  double entropy_v_per_k = 0.0;          ///< [V/K] -0.01..0.01, dOCV/dT, and its reversible heat
};

/// One cell (or one block of cells in parallel, tested as one). File: plant_sim/data/cells/*.toml.
struct CellParameters {
  std::string name;                          ///< name
  double capacity_ah = 0.0;                  ///< [Ah] 0.1..1000 capacity_ah
  double voltage_min_v = 2.5;                ///< [V] 0..5 voltage_min_v
  double voltage_max_v = 4.2;                ///< [V] 0..5 voltage_max_v
  double mass_kg = 0.0;                      ///< [kg] 0.001..100 mass_kg
  double heat_capacity_j_per_kg_k = 0.0;     ///< [J/kg/K] 100..5000 heat_capacity_j_per_kg_k
  double surface_area_m2 = 0.0;              ///< [m2] 1e-4..10 surface_area_m2
  double convection_w_per_m2_k = 0.0;        ///< [W/m2/K] 0..1000 convection_w_per_m2_k
  double surface_lag_s = 0.0;                ///< [s] 0..600 surface_lag_s, of a surface reading behind the cell
  double reference_temperature_c = 30.0;     ///< [degC] -40..80 reference_temperature_c
  double reference_current_a = 0.0;          ///< [A] 0..5000 reference_current_a
  std::vector<double> soc_breakpoints;       ///< [1] increasing, 0..1 breakpoints.soc
  std::vector<double> temperature_breakpoints_c;  ///< [degC] increasing breakpoints.temperature_c
  std::vector<double> current_breakpoints_a;      ///< [A] increasing breakpoints.current_a
  bool kinetic_law = false;  ///< between the points Arrhenius and Butler-Volmer, not straight; breakpoints.kinetic_law
  std::vector<double> ocv_polynomial_v;      ///< [V] c0 + c1 SOC + c2 SOC^2 ..., ocv.polynomial_v; or
  std::vector<double> ocv_soc;               ///< [1] increasing, ocv.soc, with
  std::vector<double> ocv_v;                 ///< [V] not decreasing, ocv.voltage_v
  std::vector<double> ocv_table_v;           ///< [V] [soc][temperature][current] ocv.table, by test; not for the plant
  CellParameterMap r0_ohm;                   ///< [ohm] > 0, section [r0]
  /// Sections [r1] [tau1] to [r4] [tau4]; the first that is not there ends them.
  std::array<CellBranch, kMostCellBranches> branches;
  CellEffects effects;                       ///< section [effects]

  [[nodiscard]] std::size_t branch_count() const {
    std::size_t count = 0;
    while (count < branches.size() && branches[count].is_there()) ++count;
    return count;
  }
};

/// How one cell differs from its neighbours: battery.cells.<n>.*, n from 1.
struct CellVariation {
  double capacity_scale = 1.0;      ///< [1] 0.1..2
  double resistance_scale = 1.0;    ///< [1] 0.1..10, on all resistances
  double initial_soc_offset = 0.0;  ///< [1] -1..1
  double leak_a = 0.0;              ///< [A] -10..10, drawn inside the cell: self-discharge, a soft short
};

struct VehicleSection {
  double mass_kg = 0;            ///< [kg] 20..3000, without driver, as weighed: the same with any pack; or
  double mass_without_pack_kg = 0;  ///< [kg] 10..3000, without driver and pack: the pack's cells come on top
  double driver_mass_kg = 0;     ///< [kg] 0..200
  double wheelbase_m = 0;        ///< [m] 0.5..5
  double track_front_m = 0;      ///< [m] 0.5..3
  double track_rear_m = 0;       ///< [m] 0.5..3
  double cg_height_m = 0;        ///< [m] 0.05..2
  double cg_rear_fraction = 0;   ///< [1] 0.1..0.9, share of the weight on the rear axle
  double front_axle_inertia_kg_m2 = 0;  ///< [kg m2] 0.01..20, both front wheels
};

struct TyreSection {
  double radius_m = 0;              ///< [m] 0.05..1, of the slipping tyre in the plant
  double lap_radius_m = 0;          ///< [m] 0.05..1, rolling radius of the lap solver; unless given radius_m
  double rolling_resistance = 0;    ///< [1] 0..0.2
  double pacejka_b = 0;             ///< [1] 0.1..50
  double pacejka_c = 0;             ///< [1] 0.5..3
  double pacejka_d = 0;             ///< [1] 0.1..4, peak longitudinal force over normal force: the tyre's grip
  double pacejka_e = 0;             ///< [1] -20..1
  double slip_speed_floor_mps = 0;  ///< [m/s] 0.05..5, least denominator of the slip ratio
  double lateral_grip = 1.0;        ///< [1] 0.1..3, peak lateral force over peak longitudinal force
  double cornering_stiffness_per_rad = 0;  ///< [1/rad] 0..100, lateral force per slip angle and load; 0: no drag
};

struct BrakeSection {
  double front_friction = 0;         ///< [1] 0..1.5
  double rear_friction = 0;          ///< [1] 0..1.5
  double front_radius_m = 0;         ///< [m] 0..0.5
  double rear_radius_m = 0;          ///< [m] 0..0.5
  double front_caliper_force_n = 0;  ///< [N] 0..1e5, at full pedal
  double rear_caliper_force_n = 0;   ///< [N] 0..1e5
  double force_scale = 1.0;          ///< [1] 0..5, on both calipers
  double front_rotor_mass_kg = 0;    ///< [kg] 0.01..20
  double rear_rotor_mass_kg = 0;     ///< [kg] 0.01..20
  double rotor_heat_capacity_j_per_kg_k = 0;  ///< [J/kg/K] 100..2000
  double front_rotor_area_m2 = 0;    ///< [m2] 0..5
  double rear_rotor_area_m2 = 0;     ///< [m2] 0..5
  double convection_w_per_m2_k = 0;  ///< [W/m2/K] 0..1000
  double full_pedal_pressure_bar = 0;  ///< [bar] 1..160, line pressure at full pedal
};

struct AeroSection {
  double drag_coefficient = 0;   ///< [1] 0..10
  double downforce_coefficient = 0;  ///< [1] -1..10, positive presses the car down
  double frontal_area_m2 = 0;    ///< [m2] 0..5
};

struct DriverSection {
  double accelerator_gain_per_mps = 0;      ///< [s/m] 0..100, pedal per m/s of speed error
  double accelerator_integral_per_m = 0;    ///< [1/m] 0..100, pedal per metre of position error
  double brake_gain_per_mps = 0;            ///< [s/m] 0..100
  double brake_integral_per_m = 0;          ///< [1/m] 0..100
  double accelerate_pedal = 0;              ///< [1] 0..1, first pedal of an acceleration
  double brake_pedal = 0;                   ///< [1] 0..1, first pedal of a braking
  double corner_pedal = 0;                  ///< [1] 0..1, pedal at constant speed
  double brake_below_mps2 = 0;              ///< [m/s2] -10..0, target deceleration that asks for the brake
  double grip_use = 0.98;                   ///< [1] 0.3..1, share of the grip that a driver on the road plans with
};

struct PowertrainSection {
  std::string kind = "electric";     ///< electric | none
  double final_drive = 0;            ///< [1] 0.5..30
  double driveline_efficiency = 0;   ///< [1] 0.3..1
  double driveline_inertia_kg_m2 = 0;  ///< [kg m2] 0.01..20, at the rear wheels; with the rotor where motor says none
  int motors = 1;                    ///< [1] 1 or 4: of the rear axle, or one a wheel, alike
  double front_torque_share = 0.5;   ///< [1] 0..1, of four motors, of the torque that drives
  double front_braking_share = 0.5;  ///< [1] 0..1, of the torque that brakes
};

struct InverterSection {
  double efficiency = 0;          ///< [1] 0.5..1
  double current_max_a = 0;       ///< [A] 1..5000, phase current, of each
  double command_timeout_s = 0;   ///< [s] 0.01..2, silence after which it stops
  double dc_voltage_min_v = 0;    ///< [V] 0..600, below it the output stage is off
  std::string protocol = "phase_current";
  double pm100_timeout_s = 0.099;  ///< [s] 0.07..2, in the place of command_timeout_s with protocol pm100
  double amk_timeout_s = 0.05;    ///< [s] 0.03..2, as that with protocol amk
  double amk_nominal_torque_nm = 9.8;  ///< [Nm] 0.1..1000, MN: what 100 % in a torque limit is
  double loss_w = 0;              ///< [W] 0..2000, while its output stage is on
  double loss_w_per_a = 0;        ///< [W/A] 0..20, of the phase current
  double loss_w_per_a2 = 0;       ///< [W/A2] 0..1, of the phase current squared
  double loss_w_per_v_a = 0;      ///< [W/V/A] 0..0.1, of DC-link voltage times phase current: switching
};

struct MotorSection {
  std::string model;                     ///< name of a motor file, or its path; empty: the car says every number itself
  double constant_nm_per_a = 0;          ///< [Nm/A, V s/rad] 0.001..10
  double efficiency = 0;                 ///< [1] 0.3..1
  double winding_resistance_ohm = 0;     ///< [ohm] 0..1
  bool winding_loss = false;             ///< adds I^2 R of the winding to the power balance
  double winding_per_kelvin = 0;         ///< [1/K] 0..0.006, rise of the winding's resistance; copper 0.0039
  double winding_reference_c = 25;       ///< [degC] 0..60, at which its resistance holds
  double drag_hysteresis_nm = 0;         ///< [Nm] 0..20, at any speed: hysteresis of the iron, bearings
  double drag_eddy_nm_s = 0;             ///< [Nm s] 0..1, by speed: eddy currents of iron and magnets
  double drag_windage_nm_s2 = 0;         ///< [Nm s2] 0..0.01, by speed squared: air about the rotor
  double rotor_inertia_kg_m2 = 0;        ///< [kg m2] 0..5, at the shaft, beside powertrain.driveline_inertia_kg_m2
  std::vector<double> curve_speed_rpm;   ///< [rpm] increasing; greatest shaft torque over speed
  std::vector<double> curve_torque_nm;   ///< [Nm] >= 0
  double curve_voltage_v = 0;            ///< [V] 0..1000, bus voltage of the curve; 0: it holds at any
  double voltage_max_v = 0;              ///< [V] 0..1000, that a pack may have open and full; 0: not stated
  double convection_w_per_m2_k = 0;      ///< [W/m2/K] 0..1000
  double surface_area_m2 = 0;            ///< [m2] 0..5
  double copper_mass_kg = 0;             ///< [kg] 0.01..200
  double steel_mass_kg = 0;              ///< [kg] 0.01..200
  double aluminium_mass_kg = 0;          ///< [kg] 0.01..200
  double copper_heat_capacity_j_per_kg_k = 0;     ///< [J/kg/K] 50..2000
  double steel_heat_capacity_j_per_kg_k = 0;      ///< [J/kg/K] 50..2000
  double aluminium_heat_capacity_j_per_kg_k = 0;  ///< [J/kg/K] 50..2000
  double insulation_conductance_w_per_k = 0;      ///< [W/K] 0.01..1e5, copper to steel
  double steel_conductance_w_per_k = 0;           ///< [W/K] 0.01..1e5, steel to aluminium
  double aluminium_conductance_w_per_k = 0;       ///< [W/K] 0.01..1e5, aluminium to its surface
};

struct BatterySection {
  std::string cell;                   ///< name of a cell file, or its path
  int cells_in_series = 0;            ///< [1] 1..144
  int cells_in_parallel = 0;          ///< [1] 1..100, of the cell file's cell
  double capacity_ah = 0;             ///< [Ah] 0.1..1000, of one cell-file cell; overrides the cell file
  double convection_w_per_m2_k = 0;   ///< [W/m2/K] 0..1000; overrides the cell file
  double initial_soc = 1.0;           ///< [1] 0..1
  double initial_temperature_c = 0;   ///< [degC] -40..80
  double lookup_current_floor_a = 0;  ///< [A] 0..100, per cell-file cell; below it the last lookup current stays
  double mass_over_cells = 1.0;       ///< [1] 1..5, mass of the pack over that of its cells
  double contact_resistance_ohm = 0;  ///< [ohm] 0..1, from cells to terminals; its heat does not reach the cells
  double balancing_resistance_ohm = 33.0;  ///< [ohm] 1..1e5, of a shunt across a cell in series
  double sense_resistance_ohm = 0.5;  ///< [ohm] 0..100, of the wires that carry a shunt's current and are read by
  std::vector<CellVariation> cells;   ///< battery.cells.<n>.*; empty or up to cells_in_series entries
};

struct ContactorSection {
  double resistance_ohm = 0;            ///< [ohm] 1e-6..1, both AIRs, fuse and cables
  double precharge_resistance_ohm = 0;  ///< [ohm] 1..1e5
  double dc_link_capacitance_f = 0;     ///< [F] 1e-5..0.1
  double bleed_resistance_ohm = 0;      ///< [ohm] 10..1e7, across the DC link
  double close_time_s = 0;              ///< [s] 0..0.5
  double open_time_s = 0;               ///< [s] 0..0.25
};

struct ChargerSection {
  double power_w = 3300.0;     ///< [W] 0..1e6, at its output
  double current_max_a = 32.0; ///< [A] 0..1000
  double response_s = 0.5;     ///< [s] 0..60, of its current behind a command, first order
};

struct LowVoltageSection {
  double power_w = 0;  ///< [W] 0..5000, drawn from the DC link
};

struct SensorSection {
  bool noise = false;          ///< noise of the Orion's inputs and of the dual-range current sensor
  bool quantisation = false;   ///< steps of the Orion's inputs and of the dual-range current sensor
  int temperature_count = 0;   ///< [1] 1..36, thermistors, spread over the cells
  double cell_noise_v = 0;             ///< [V] 0..0.1, standard deviation
  double cell_step_v = 0;              ///< [V] 0..0.1
  double current_low_range_a = 0;      ///< [A] 1..1e4, where the fine channel ends
  double current_low_noise_a = 0;      ///< [A] 0..100
  double current_high_noise_a = 0;     ///< [A] 0..100
  double current_low_step_a = 0;       ///< [A] 0..10
  double current_high_step_a = 0;      ///< [A] 0..10
  double temperature_noise_k = 0;      ///< [K] 0..10
  double temperature_step_k = 0;       ///< [K] 0..5
  ReadingErrors all_cells, all_thermistors;   ///< sensors.cells.*, sensors.thermistors.*
  std::vector<ChannelErrors> cells, thermistors; ///< sensors.cells.<n>.*: empty or up to as many as there are
  ReadingErrors pack_current, pack_voltage, dc_link_voltage, phase_current, motor_speed;
  ReadingErrors motor_temperature, inverter_temperature;
  ReadingErrors wheel_front_left, wheel_front_right, wheel_rear_left, wheel_rear_right;
  ReadingErrors apps1, apps2, brake_front, brake_rear;
};

struct EnvironmentSection {
  double ambient_c = 0;              ///< [degC] -40..60
  double air_density_kg_per_m3 = 0;  ///< [kg/m3] 0.5..2
  double gravity_mps2 = 0;           ///< [m/s2] 9..10
  double wind_mps = 0;               ///< [m/s] 0..30
  double wind_from_deg = 0;          ///< [deg] -360..360, where it comes from; 0: against the car at the start line,
                                     ///< 90: from its right there
};

struct AssertionSection {
  double speed_error_max_mps = 0;           ///< [m/s] 0.1..100
  double battery_temperature_max_c = 0;     ///< [degC] 0..200
  double motor_temperature_max_c = 0;       ///< [degC] 0..500, copper
  double off_course_max_m = 1.5;            ///< [m] 0.1..20, distance from the line of the course
};

struct VehicleParameters {
  std::string name;
  VehicleSection vehicle;
  TyreSection tyres;
  BrakeSection brakes;
  AeroSection aero;
  DriverSection driver;
  PowertrainSection powertrain;
  InverterSection inverter;
  MotorSection motor;  ///< the file that motor.model names, if any, overrides of [motor] applied
  BatterySection battery;
  CellParameters cell;  ///< the file that battery.cell names, overrides of [battery] applied
  ContactorSection contactors;
  ChargerSection charger;
  LowVoltageSection low_voltage;
  SensorSection sensors;
  EnvironmentSection environment;
  BmsSection bms;
  MasterSection master;
  AssertionSection assertions;
};

}  // namespace voltlap::plant
