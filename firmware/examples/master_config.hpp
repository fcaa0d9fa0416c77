// The master controller's configuration for vtm16e. Made by voltlap 0.1.0; make it again with
//   voltlap firmware-tables --master-out FILE
#pragma once
#include <cstdint>

#include "master/config.hpp"

namespace voltlap::master {

// Whose configuration it is, and its number, by which an image of another car is told. After a
// change by hand set it to 0: whose it is, is not known then.
inline constexpr char kMasterCar[] = "vtm16e";
inline constexpr std::uint32_t kMasterNumber = 0x6C16E183U;

inline constexpr Config kMasterConfig = [] {
  Config c{};
  // released, full, range: 0.5, 4.5, 0.3 to 4.7 V
  c.apps1 = {Potential::from_raw(5000), Potential::from_raw(45000),
             Potential::from_raw(3000), Potential::from_raw(47000)};
  // released, full, range: 0.25, 2.25, 0.15 to 2.35 V
  c.apps2 = {Potential::from_raw(2500), Potential::from_raw(22500),
             Potential::from_raw(1500), Potential::from_raw(23500)};
  c.apps_disagreement_max = Ratio::from_raw(100000);                  // 10 %
  c.apps_implausible_time = Duration::from_ms(100);                   // 0.1 s
  c.brake_sensor_fail_time = Duration::from_ms(100);                  // 0.1 s
  c.brake_throttle_limit = Ratio::from_raw(250000);                   // 25 %
  c.pedal_release_level = Ratio::from_raw(50000);                     // 5 %
  c.pedal_dead_zone = Ratio::from_raw(0);                             // 0 %
  c.pedal_at_half = Ratio::from_raw(500000);                          // 50 %
  c.brake_pressed_level = Pressure::from_raw(3000);                   // 3 bar
  c.brake_compare_level = Pressure::from_raw(20000);                  // 20 bar
  c.phase_current_max = Current::from_raw(550000);                    // 550 A
  c.request_rise_ma_per_ms = 20000;                                   // 20000 A/s
  c.regen_current_max = Current::from_raw(0);                         // 0 A
  c.regen_full_level = Pressure::from_raw(40000);                     // 40 bar
  c.arbitration = Arbitration::kPowerBalance;
  c.motor_constant_unm_per_a = 150000;                                // 0.15 Nm/A
  c.drive_efficiency = Ratio::from_raw(900000);                       // 90 %
  c.power_max_mw = 79000000;                                          // 79 kW
  c.pack_resistance = Resistance::from_raw(32526);                    // 32.526 mOhm
  c.motor_speed_max = MotorSpeed::from_raw(12000);                    // 12000 rpm
  c.ceiling_rise_ma_per_s = 2000000;                                  // 2000 A/s
  c.trim_gain = Ratio::from_raw(200000);                              // 20 %
  c.trim_max = Ratio::from_raw(500000);                               // 50 %
  c.trim_decay_ppm_per_s = 100000;                                    // 10 %/s
  c.battery_limit_off = Current::from_raw(1000);                      // 1 A
  c.battery_limit_on = Current::from_raw(5000);                       // 5 A
  c.regen_speed_min = Speed::from_raw(1389);                          // 1.389 m/s
  c.inverter_excess_max = Current::from_raw(50000);                   // 50 A
  c.limp_share = Ratio::from_raw(0);                                  // 0 %
  c.motor_derate_start = Temperature::from_raw(1400);                 // 140 degC
  c.motor_derate_end = Temperature::from_raw(1600);                   // 160 degC
  c.inverter_derate_start = Temperature::from_raw(800);               // 80 degC
  c.inverter_derate_end = Temperature::from_raw(950);                 // 95 degC
  c.ts_request_timeout = Duration::from_ms(10000);                    // 10 s
  c.rtd_sound_time = Duration::from_ms(2000);                         // 2 s
  c.rx_timeout = Duration::from_ms(50);                               // 0.05 s
  return c;
}();
static_assert(config_check(kMasterConfig) == ConfigError::kNone, "this firmware refuses the configuration: make the"
              " header again");

}  // namespace voltlap::master
