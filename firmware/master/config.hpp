// SPDX-License-Identifier: Apache-2.0
// Every number of the master controller, with its unit and its source; `config_check` says whether they fit together.
#pragma once
#include "base/time.hpp"
#include "base/units.hpp"

namespace voltlap::master {

/// One accelerator position sensor: a straight line between two voltages, and the range outside which it has failed.
struct AppsChannel {
  Potential released;
  Potential full;
  Potential range_min;
  Potential range_max;
};

/// How a DC limit of the battery becomes a ceiling on the phase current.
enum class Arbitration : std::uint8_t {
  kPowerBalance = 0,  ///< phase current whose shaft power the limit can feed: I_dc V eta / (K omega)
  kLiteral = 1,       ///< phase current <= I_dc, as printed
};

struct Config {
  // Pedals. T.4.2.10 gives 0.5 and 4.5 V as an example of the range; 0.2 V of margin keeps noise from being a fault.
  // The second channel has half the slope, so that a short between the two cannot look plausible.
  AppsChannel apps1{Potential::from_raw(5'000), Potential::from_raw(45'000), Potential::from_raw(3'000),
                    Potential::from_raw(47'000)};
  AppsChannel apps2{Potential::from_raw(2'500), Potential::from_raw(22'500), Potential::from_raw(1'500),
                    Potential::from_raw(23'500)};
  Ratio apps_disagreement_max = Ratio::from_raw(100'000);          ///< T.4.2.4: 10 % of pedal travel
  Duration apps_implausible_time = Duration::from_ms(100);         ///< T.4.2.5
  Duration brake_sensor_fail_time = Duration::from_ms(100);        ///< T.4.3
  Ratio brake_throttle_limit = Ratio::from_raw(250'000);           ///< EV.4.7: APPS above 25 % with the brake on
  Ratio pedal_release_level = Ratio::from_raw(50'000);             ///< EV.4.7: back on power below 5 %
  Ratio pedal_dead_zone = Ratio::from_raw(0);                      ///< travel without request; none by default
  Pressure brake_pressed_level = Pressure::from_raw(3'000);        ///< 3 bar: above line noise, below a light stop

  // Request.
  Current phase_current_max = Current::from_raw(550'000);          ///< limit of the inverter, section 4.7.2
  std::int32_t request_rise_ma_per_ms = 20'000;                    ///< full request in 30 ms
  Current regen_current_max = Current::from_raw(0);                ///< phase current; 0 = no regeneration
  Pressure regen_full_level = Pressure::from_raw(40'000);          ///< brake pressure of full regeneration

  // Ceilings.
  Arbitration arbitration = Arbitration::kPowerBalance;
  std::int32_t motor_constant_unm_per_a = 150'000;                 ///< [uNm/A] and [uV s/rad], 0.15 Nm/A
  Ratio drive_efficiency = Ratio::from_raw(900'000);               ///< shaft over DC power, a low estimate
  std::int32_t power_max_mw = 79'000'000;                          ///< EV.3.3: 80 kW, less 1 kW of measuring margin
  MotorSpeed motor_speed_max = MotorSpeed::from_raw(12'000);       ///< assumed when the speed is not known
  std::int32_t ceiling_rise_ma_per_s = 2'000'000;                  ///< a ceiling falls at once and rises at this rate
  Ratio trim_gain = Ratio::from_raw(200'000);                      ///< share of a measured excess taken off each step
  Ratio trim_max = Ratio::from_raw(500'000);                       ///< most that the trim may take
  std::int32_t trim_decay_ppm_per_s = 100'000;                     ///< how fast the trim gives back
  Current battery_limit_off = Current::from_raw(1'000);            ///< below it a battery direction is shut ...
  Current battery_limit_on = Current::from_raw(5'000);             ///< ... until its limit is above this
  Speed regen_speed_min = Speed::from_raw(1'389);                  ///< EV.3.3.3: 5 km/h, rounded up
  Temperature motor_derate_start = Temperature::from_raw(1'400);   ///< assumed: class H winding, 180 degC ...
  Temperature motor_derate_end = Temperature::from_raw(1'600);     ///< ... less 20 K; no torque from here on
  Temperature inverter_derate_start = Temperature::from_raw(800);  ///< assumed: usual heat sink limit
  Temperature inverter_derate_end = Temperature::from_raw(950);

  // Drive states and the last gate.
  Duration ts_request_timeout = Duration::from_ms(10'000);         ///< longest wait for the battery's contactors
  Duration rtd_sound_time = Duration::from_ms(2'000);              ///< EV.9: 1 to 3 s
  Duration rx_timeout = Duration::from_ms(50);                     ///< oldest input that may carry torque
};

/// The first thing found wrong with a configuration.
enum class ConfigError : std::uint8_t {
  kNone = 0,
  kAppsChannel,
  kPedalLevels,
  kBrakeLevels,
  kRequest,
  kMotor,
  kCeilings,
  kDerating,
  kTimes,
};

namespace config_detail {

constexpr bool channel_ok(const AppsChannel& c) {
  return Potential::from_raw(0) < c.range_min && c.range_min < c.released && c.released < c.full &&
         c.full < c.range_max && c.range_max < Potential::from_raw(50'000);
}
constexpr bool share_ok(Ratio low, Ratio r) { return low <= r && r <= Ratio::from_raw(1'000'000); }
constexpr bool time_ok(Duration t, std::int32_t max_ms) { return t.ms() > 0 && t.ms() <= max_ms; }

}  // namespace config_detail

/// Refuses an all-zero, contradictory or unlawful configuration: bounds that a rule sets cannot be configured away.
[[nodiscard]] constexpr ConfigError config_check(const Config& c) {
  using namespace config_detail;
  constexpr Ratio kNothing = Ratio::from_raw(0);
  if (!channel_ok(c.apps1) || !channel_ok(c.apps2)) return ConfigError::kAppsChannel;
  if (c.apps_disagreement_max <= kNothing || c.apps_disagreement_max > Ratio::from_raw(100'000) ||
      c.pedal_release_level <= kNothing || c.pedal_release_level > Ratio::from_raw(50'000) ||
      c.brake_throttle_limit <= c.pedal_release_level || c.brake_throttle_limit > Ratio::from_raw(250'000) ||
      c.pedal_dead_zone < kNothing || c.pedal_dead_zone > Ratio::from_raw(200'000)) {
    return ConfigError::kPedalLevels;
  }
  if (c.brake_pressed_level.raw() <= 0 || c.brake_pressed_level >= c.regen_full_level) {
    return ConfigError::kBrakeLevels;
  }
  if (c.phase_current_max.raw() <= 0 || c.phase_current_max.raw() > 550'000 || c.request_rise_ma_per_ms <= 0 ||
      c.regen_current_max.raw() < 0 || c.regen_current_max > c.phase_current_max) {
    return ConfigError::kRequest;
  }
  if (c.motor_constant_unm_per_a < 1'000 || c.motor_constant_unm_per_a > 10'000'000 || c.motor_speed_max.raw() <= 0 ||
      c.motor_speed_max.raw() > 12'000 || !share_ok(Ratio::from_raw(300'000), c.drive_efficiency)) {
    return ConfigError::kMotor;
  }
  if (c.power_max_mw <= 0 || c.power_max_mw > 80'000'000 || c.ceiling_rise_ma_per_s <= 0 ||
      !share_ok(kNothing, c.trim_gain) || !share_ok(kNothing, c.trim_max) || c.trim_decay_ppm_per_s <= 0 ||
      c.battery_limit_off.raw() < 0 || c.battery_limit_on < c.battery_limit_off ||
      c.regen_speed_min < Speed::from_raw(1'389)) {
    return ConfigError::kCeilings;
  }
  if (c.motor_derate_start >= c.motor_derate_end || c.inverter_derate_start >= c.inverter_derate_end) {
    return ConfigError::kDerating;
  }
  if (!time_ok(c.apps_implausible_time, 100) || !time_ok(c.brake_sensor_fail_time, 100) ||
      !time_ok(c.rx_timeout, 50) || !time_ok(c.ts_request_timeout, 60'000) ||
      !time_ok(c.rtd_sound_time, 3'000) || c.rtd_sound_time.ms() < 1'000) {
    return ConfigError::kTimes;
  }
  return ConfigError::kNone;
}

static_assert(config_check(Config{}) == ConfigError::kNone, "the default configuration must pass its own check");

}  // namespace voltlap::master
