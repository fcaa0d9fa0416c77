// SPDX-License-Identifier: Apache-2.0
// What the firmware is told beyond what it takes from the car: the fields of bms::Config and master::Config that a team
// sets, in SI units. A field without value follows what its row in firmware_parameter_definitions.cpp names.
#pragma once
#include <optional>
#include <string>
#include <vector>

namespace voltlap::plant {

struct BmsSection {
  double discharge_current_max_a = 0;                  ///< [A] 0..1000
  double charge_current_max_a = 0;                     ///< [A] 0..1000
  double temperature_max_c = 0;                        ///< [degC] 0..100
  double resistance_ohm = 0.0;                         ///< [ohm] 0..1
  double resistance_per_kelvin = 0.0;                  ///< [1/K] -0.2..0.2
  double capacity_ah = 0.0;                            ///< [Ah] 0..1000
  std::vector<double> ocv_soc;                         ///< [1] 0..1
  std::vector<double> ocv_v;                           ///< [V] 0..5
  std::string soc_method = "coulomb";
  std::string limit_method = "equation";
  double limit_horizon_s = 1.0;                        ///< [s] 0..30
  double soc_start_current_a = 1.0;                    ///< [A] 0..100
  std::optional<double> cell_voltage_min_v;            ///< [V] 0..5
  std::optional<double> cell_voltage_max_v;            ///< [V] 0..5
  double limit_rise_a_per_s = 500.0;                   ///< [A/s] 0..1e6
  std::optional<double> temperature_derating_start_c;  ///< [degC] -40..100
  double charge_temperature_min_c = 0.0;               ///< [degC] -60..60
  double soc_derating_start = 0.0;                     ///< [1] 0..1
  double energy_to_go_km = 0.0;                        ///< [km] 0..1000; 0: off
  double energy_to_go_reserve = 0.03;                  ///< [1] 0..1
  std::optional<double> cell_voltage_trip_low_v;       ///< [V] 0..5
  std::optional<double> cell_voltage_trip_high_v;      ///< [V] 0..5
  double cell_voltage_plausible_min_v = 0.5;           ///< [V] 0..5
  double cell_voltage_plausible_max_v = 5.0;           ///< [V] 0..10
  std::optional<double> discharge_current_trip_a;      ///< [A] 0..100000
  std::optional<double> charge_current_trip_a;         ///< [A] 0..100000
  double voltage_mismatch = 0.05;                      ///< [1] 0..1
  double voltage_trip_time_s = 0.5;                    ///< [s] 0..60
  double temperature_trip_time_s = 1.0;                ///< [s] 0..60
  double current_trip_time_s = 1.0;                    ///< [s] 0..60
  double voltage_mismatch_time_s = 1.0;                ///< [s] 0..60
  double measurement_lost_time_s = 0.5;                ///< [s] 0..60
  double precharge_ratio = 0.95;                       ///< [1] 0..1
  double precharge_timeout_s = 5.0;                    ///< [s] 0..600
  double precharge_time_min_s = 0.02;                  ///< [s] 0..600
  double contactor_time_s = 0.2;                       ///< [s] 0..60
  double contactor_drop_time_s = 0.02;                 ///< [s] 0..60
  double isolation_time_s = 0.1;                       ///< [s] 0..60
  double dc_link_discharge_time_s = 5.0;               ///< [s] 0..600
  double dc_link_welded = 0.5;                         ///< [1] 0..1
  double charger_current_max_a = 0.0;                  ///< [A] 0..1000
  double charge_margin_v = 0.005;                      ///< [V] 0..1
  std::optional<double> charge_current_end_a;          ///< [A] 0..1000
  std::optional<double> balancing_voltage_min_v;       ///< [V] 0..5
  double balancing_difference_v = 0.003;               ///< [V] 0..5
  double balancing_time_max_s = 86400.0;               ///< [s] 0..1e6
  double balancing_current_max_a = 1.0;                ///< [A] 0..1000
};

struct MasterSection {
  double apps1_released_v = 0.5;                       ///< [V] 0..5
  double apps1_full_v = 4.5;                           ///< [V] 0..5
  double apps1_range_min_v = 0.3;                      ///< [V] 0..5
  double apps1_range_max_v = 4.7;                      ///< [V] 0..5
  double apps2_released_v = 0.25;                      ///< [V] 0..5
  double apps2_full_v = 2.25;                          ///< [V] 0..5
  double apps2_range_min_v = 0.15;                     ///< [V] 0..5
  double apps2_range_max_v = 2.35;                     ///< [V] 0..5
  double apps_disagreement_max = 0.1;                  ///< [1] 0..1
  double apps_implausible_time_s = 0.1;                ///< [s] 0..60
  double brake_sensor_fail_time_s = 0.1;               ///< [s] 0..60
  double brake_throttle_limit = 0.25;                  ///< [1] 0..1
  double pedal_release_level = 0.05;                   ///< [1] 0..1
  double pedal_dead_zone = 0.0;                        ///< [1] 0..1
  double pedal_at_half = 0.5;                          ///< [1] 0..1
  double brake_pressed_bar = 3.0;                      ///< [bar] 0..200
  double brake_compare_bar = 20.0;                     ///< [bar] 0..200
  std::optional<double> phase_current_max_a;           ///< [A] 0..5000
  double request_rise_a_per_s = 20000.0;               ///< [A/s] 0..2e6
  double regen_current_max_a = 0.0;                    ///< [A] 0..5000
  double regen_full_brake_bar = 40.0;                  ///< [bar] 0..200
  std::string arbitration = "power_balance";
  std::optional<double> motor_constant_nm_per_a;       ///< [Nm/A] 0.001..10
  double drive_efficiency = 0.9;                       ///< [1] 0..1
  double power_max_kw = 79.0;                          ///< [kW] 0..1000
  double motor_speed_max_rpm = 12000.0;                ///< [rpm] 0..100000
  double ceiling_rise_a_per_s = 2000.0;                ///< [A/s] 0..2e6
  double trim_gain = 0.2;                              ///< [1] 0..1
  double trim_max = 0.5;                               ///< [1] 0..1
  double trim_decay_per_s = 0.1;                       ///< [1/s] 0..1000
  double battery_limit_off_a = 1.0;                    ///< [A] 0..1000
  double battery_limit_on_a = 5.0;                     ///< [A] 0..1000
  double regen_speed_min_mps = 1.389;                  ///< [m/s] 0..200
  double inverter_excess_max_a = 50.0;                 ///< [A] 0..2000
  double limp_share = 0.0;                             ///< [1] 0..1
  double motor_derating_start_c = 140.0;               ///< [degC] -40..500
  double motor_derating_end_c = 160.0;                 ///< [degC] -40..500
  double inverter_derating_start_c = 80.0;             ///< [degC] -40..500
  double inverter_derating_end_c = 95.0;               ///< [degC] -40..500
  double ts_request_timeout_s = 10.0;                  ///< [s] 0..600
  double rtd_sound_time_s = 2.0;                       ///< [s] 0..60
  double rx_timeout_s = 0.05;                          ///< [s] 0..60
};

}  // namespace voltlap::plant
