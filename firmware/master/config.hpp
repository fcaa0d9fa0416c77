// SPDX-License-Identifier: Apache-2.0
// Every number of the master controller, with its unit and its source; `config_check` says whether they fit together.
#pragma once
#include <cstdint>

#include "base/condition.hpp"
#include "base/inverter_protocol.hpp"
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
  Ratio pedal_at_half = Ratio::from_raw(500'000);                  ///< request at half travel; a half: straight
  Pressure brake_pressed_level = Pressure::from_raw(3'000);        ///< 3 bar: above line noise, below a light stop
  Pressure brake_compare_level = Pressure::from_raw(20'000);       ///< above it in one circuit the other is pressed

  // Request.
  Current phase_current_max = Current::from_raw(550'000);          ///< limit of the inverter, section 4.7.2
  std::int32_t request_rise_ma_per_ms = 20'000;                    ///< full request in 30 ms
  Current regen_current_max = Current::from_raw(0);                ///< phase current; 0 = no regeneration
  Pressure regen_full_level = Pressure::from_raw(40'000);          ///< brake pressure of full regeneration

  // Ceilings.
  Arbitration arbitration = Arbitration::kPowerBalance;
  std::int32_t motor_constant_unm_per_a = 150'000;                 ///< [uNm/A] and [uV s/rad], 0.15 Nm/A
  Ratio drive_efficiency = Ratio::from_raw(900'000);               ///< shaft over DC power until measured, a low one
  std::int32_t power_max_mw = 79'000'000;                          ///< EV.3.3: 80 kW, less 1 kW of measuring margin
  Resistance pack_resistance = Resistance::from_raw(0);            ///< of a fresh load, until measured
  MotorSpeed motor_speed_max = MotorSpeed::from_raw(12'000);       ///< no torque beyond; assumed when not known
  std::int32_t ceiling_rise_ma_per_s = 2'000'000;                  ///< a ceiling falls at once and rises at this rate
  Ratio trim_gain = Ratio::from_raw(200'000);                      ///< share of a measured excess taken off each step
  Ratio trim_max = Ratio::from_raw(500'000);                       ///< most that the trim may take
  std::int32_t trim_decay_ppm_per_s = 100'000;                     ///< how fast the trim gives back
  Current battery_limit_off = Current::from_raw(1'000);            ///< below it a battery direction is shut ...
  Current battery_limit_on = Current::from_raw(5'000);             ///< ... until its limit is above this
  Speed regen_speed_min = Speed::from_raw(1'389);                  ///< EV.3.3.3: 5 km/h, rounded up
  Current inverter_excess_max = Current::from_raw(50'000);         ///< assumed: a tenth of the largest command; MST-041
  Ratio limp_share = Ratio::from_raw(0);                           ///< of the current, when a temperature is not known
  Temperature motor_derate_start = Temperature::from_raw(1'400);   ///< assumed: class H winding, 180 degC ...
  Temperature motor_derate_end = Temperature::from_raw(1'600);     ///< ... less 20 K; no torque from here on
  Temperature inverter_derate_start = Temperature::from_raw(800);  ///< assumed: usual heat sink limit
  Temperature inverter_derate_end = Temperature::from_raw(950);

  // Inverter.
  InverterProtocol inverter_protocol = InverterProtocol::kPhaseCurrent;
  // Of a car with a motor a wheel, which is one with protocol kAmk.
  Current motor_current_max = Current::from_raw(550'000);          ///< of each, at its inverter's limit
  Ratio front_drive_share = Ratio::from_raw(500'000);              ///< of the driving current, at both front wheels
  Ratio front_brake_share = Ratio::from_raw(500'000);              ///< of the braking current
  std::int32_t nominal_torque_mnm = 9'800;                         ///< MN, what 100 % of a torque limit is

  // Drive states and the last gate.
  Duration ts_request_timeout = Duration::from_ms(10'000);         ///< longest wait for the battery's contactors
  Duration rtd_sound_time = Duration::from_ms(2'000);              ///< EV.9: 1 to 3 s
  Duration rx_timeout = Duration::from_ms(50);                     ///< oldest input that may carry torque
};

/// What config_check found wrong first: one name for each condition.
enum class ConfigError : std::uint8_t {
  kNone = 0,
  // pedals: 0 < range_min < released < full < range_max < 5 V
  kApps1RangeMin,
  kApps1Released,
  kApps1Full,
  kApps1RangeMax,
  kApps1Supply,
  kApps2RangeMin,
  kApps2Released,
  kApps2Full,
  kApps2RangeMax,
  kApps2Supply,
  kAppsDisagreement,
  kAppsDisagreementRule,
  kPedalRelease,
  kPedalReleaseRule,
  kBrakeThrottle,
  kBrakeThrottleRule,
  kDeadZone,
  kDeadZoneMax,
  kPedalAtHalf,
  kPedalAtHalfMax,
  kBrakePressed,
  kBrakeCompare,
  kRegenFull,
  // request
  kPhaseCurrent,
  kPhaseCurrentRange,
  kRequestRise,
  kRegenCurrent,
  kRegenCurrentPhase,
  // ceilings
  kMotorConstantMin,
  kMotorConstantMax,
  kMotorSpeed,
  kMotorSpeedRange,
  kDriveEfficiencyMin,
  kDriveEfficiencyMax,
  kPower,
  kPowerRule,
  kPackResistance,
  kPackResistanceMax,
  kCeilingRise,
  kTrimGain,
  kTrimGainWhole,
  kTrimMax,
  kTrimMaxWhole,
  kTrimDecay,
  kBatteryLimitOff,
  kBatteryLimitOn,
  kRegenSpeedRule,
  kInverterExcess,
  kInverterExcessMax,
  kLimpShare,
  kLimpShareMax,
  kMotorDerating,
  kInverterDerating,
  // motors at the wheels
  kMotorSpeedRangeAmk,
  kMotorCurrent,
  kFrontDriveShare,
  kFrontDriveShareMax,
  kFrontBrakeShare,
  kFrontBrakeShareMax,
  kNominalTorque,
  // times
  kAppsImplausibleTime,
  kAppsImplausibleTimeRule,
  kBrakeSensorFailTime,
  kBrakeSensorFailTimeRule,
  kRxTimeout,
  kRxTimeoutMax,
  kTsRequestTimeout,
  kTsRequestTimeoutMax,
  kRtdSoundTimeMin,
  kRtdSoundTimeMax,
};

namespace check {

inline constexpr Ratio kNothing{};
inline constexpr Ratio kWhole = Ratio::from_raw(1'000'000);
inline constexpr Potential kSupply = Potential::from_raw(50'000);
inline constexpr Ratio kAppsDisagreementMax = Ratio::from_raw(100'000);    // T.4.2.4
inline constexpr Ratio kPedalReleaseMax = Ratio::from_raw(50'000);         // EV.4.7
inline constexpr Ratio kBrakeThrottleMax = Ratio::from_raw(250'000);       // EV.4.7
inline constexpr Ratio kDeadZoneMax = Ratio::from_raw(200'000);
inline constexpr Ratio kPedalAtHalfMin = Ratio::from_raw(250'000), kPedalAtHalfMax = Ratio::from_raw(750'000);
inline constexpr Ratio kLimpShareMax = Ratio::from_raw(500'000);
inline constexpr Current kPhaseCurrentMax = Current::from_raw(550'000);    // range of InverterCommand
inline constexpr std::int32_t kMotorConstantMinUnm = 1'000, kMotorConstantMaxUnm = 10'000'000;
inline constexpr MotorSpeed kMotorSpeedMax = MotorSpeed::from_raw(12'000);     // range of InverterStatus and PM100
inline constexpr MotorSpeed kMotorSpeedMaxAmk = MotorSpeed::from_raw(20'000);  // of the kit's motors
inline constexpr Ratio kDriveEfficiencyMin = Ratio::from_raw(300'000);
inline constexpr std::int32_t kPowerMaxMw = 80'000'000;                    // EV.3.3
inline constexpr Current kInverterExcessMax = Current::from_raw(1'100'000);  // from full drive to full braking
inline constexpr Resistance kPackResistanceMax = Resistance::from_raw(5'000'000);  // 144 cells of 35 mOhm
inline constexpr Speed kRegenSpeedMin = Speed::from_raw(1'389);            // EV.3.3.3
inline constexpr Duration kImplausibleTimeMax = Duration::from_ms(100);    // T.4.2.5, T.4.3
inline constexpr Duration kRxTimeoutMax = Duration::from_ms(50);
inline constexpr Duration kTsRequestTimeoutMax = Duration::from_ms(60'000);
inline constexpr Duration kRtdSoundMin = Duration::from_ms(1'000), kRtdSoundMax = Duration::from_ms(3'000);  // EV.9

/// The five conditions of a channel have consecutive names, from `first` on.
constexpr ConfigError channel(const AppsChannel& c, ConfigError first) {
  const auto named = [first](int k) { return static_cast<ConfigError>(static_cast<int>(first) + k); };
  return first_broken<ConfigError>({
      {Potential{} < c.range_min, named(0)},
      {c.range_min < c.released, named(1)},
      {c.released < c.full, named(2)},
      {c.full < c.range_max, named(3)},
      {c.range_max < kSupply, named(4)},
  });
}

constexpr ConfigError pedals(const Config& c) {
  return first_broken<ConfigError>({
      {c.apps_disagreement_max > kNothing, ConfigError::kAppsDisagreement},
      {c.apps_disagreement_max <= kAppsDisagreementMax, ConfigError::kAppsDisagreementRule},
      {c.pedal_release_level > kNothing, ConfigError::kPedalRelease},
      {c.pedal_release_level <= kPedalReleaseMax, ConfigError::kPedalReleaseRule},
      {c.brake_throttle_limit > c.pedal_release_level, ConfigError::kBrakeThrottle},
      {c.brake_throttle_limit <= kBrakeThrottleMax, ConfigError::kBrakeThrottleRule},
      {c.pedal_dead_zone >= kNothing, ConfigError::kDeadZone},
      {c.pedal_dead_zone <= kDeadZoneMax, ConfigError::kDeadZoneMax},
      {c.pedal_at_half >= kPedalAtHalfMin, ConfigError::kPedalAtHalf},
      {c.pedal_at_half <= kPedalAtHalfMax, ConfigError::kPedalAtHalfMax},
      {c.brake_pressed_level > Pressure{}, ConfigError::kBrakePressed},
      {c.brake_pressed_level < c.brake_compare_level, ConfigError::kBrakeCompare},
      {c.brake_pressed_level < c.regen_full_level, ConfigError::kRegenFull},
  });
}

constexpr ConfigError request(const Config& c) {
  return first_broken<ConfigError>({
      {c.phase_current_max > Current{}, ConfigError::kPhaseCurrent},
      {c.phase_current_max <= kPhaseCurrentMax, ConfigError::kPhaseCurrentRange},
      {c.request_rise_ma_per_ms > 0, ConfigError::kRequestRise},
      {c.regen_current_max >= Current{}, ConfigError::kRegenCurrent},
      {c.regen_current_max <= c.phase_current_max, ConfigError::kRegenCurrentPhase},
  });
}

constexpr ConfigError ceilings(const Config& c) {
  return first_broken<ConfigError>({
      {c.motor_constant_unm_per_a >= kMotorConstantMinUnm, ConfigError::kMotorConstantMin},
      {c.motor_constant_unm_per_a <= kMotorConstantMaxUnm, ConfigError::kMotorConstantMax},
      {c.motor_speed_max > MotorSpeed{}, ConfigError::kMotorSpeed},
      {c.inverter_protocol == InverterProtocol::kAmk || c.motor_speed_max <= kMotorSpeedMax,
       ConfigError::kMotorSpeedRange},
      {c.drive_efficiency >= kDriveEfficiencyMin, ConfigError::kDriveEfficiencyMin},
      {c.drive_efficiency <= kWhole, ConfigError::kDriveEfficiencyMax},
      {c.power_max_mw > 0, ConfigError::kPower},
      {c.power_max_mw <= kPowerMaxMw, ConfigError::kPowerRule},
      {c.pack_resistance >= Resistance{}, ConfigError::kPackResistance},
      {c.pack_resistance <= kPackResistanceMax, ConfigError::kPackResistanceMax},
      {c.ceiling_rise_ma_per_s > 0, ConfigError::kCeilingRise},
      {c.trim_gain >= kNothing, ConfigError::kTrimGain},
      {c.trim_gain <= kWhole, ConfigError::kTrimGainWhole},
      {c.trim_max >= kNothing, ConfigError::kTrimMax},
      {c.trim_max <= kWhole, ConfigError::kTrimMaxWhole},
      {c.trim_decay_ppm_per_s > 0, ConfigError::kTrimDecay},
      {c.battery_limit_off >= Current{}, ConfigError::kBatteryLimitOff},
      {c.battery_limit_on >= c.battery_limit_off, ConfigError::kBatteryLimitOn},
      {c.regen_speed_min >= kRegenSpeedMin, ConfigError::kRegenSpeedRule},
      {c.inverter_excess_max > Current{}, ConfigError::kInverterExcess},
      {c.inverter_excess_max <= kInverterExcessMax, ConfigError::kInverterExcessMax},
      {c.limp_share >= kNothing, ConfigError::kLimpShare},
      {c.limp_share <= kLimpShareMax, ConfigError::kLimpShareMax},
      {c.motor_derate_start < c.motor_derate_end, ConfigError::kMotorDerating},
      {c.inverter_derate_start < c.inverter_derate_end, ConfigError::kInverterDerating},
  });
}

constexpr ConfigError wheels(const Config& c) {
  return first_broken<ConfigError>({
      {c.motor_speed_max <= kMotorSpeedMaxAmk, ConfigError::kMotorSpeedRangeAmk},
      {c.motor_current_max > Current{}, ConfigError::kMotorCurrent},
      {c.front_drive_share >= kNothing, ConfigError::kFrontDriveShare},
      {c.front_drive_share <= kWhole, ConfigError::kFrontDriveShareMax},
      {c.front_brake_share >= kNothing, ConfigError::kFrontBrakeShare},
      {c.front_brake_share <= kWhole, ConfigError::kFrontBrakeShareMax},
      {c.nominal_torque_mnm > 0, ConfigError::kNominalTorque},
  });
}

constexpr ConfigError times(const Config& c) {
  constexpr Duration kZero{};
  return first_broken<ConfigError>({
      {c.apps_implausible_time > kZero, ConfigError::kAppsImplausibleTime},
      {c.apps_implausible_time <= kImplausibleTimeMax, ConfigError::kAppsImplausibleTimeRule},
      {c.brake_sensor_fail_time > kZero, ConfigError::kBrakeSensorFailTime},
      {c.brake_sensor_fail_time <= kImplausibleTimeMax, ConfigError::kBrakeSensorFailTimeRule},
      {c.rx_timeout > kZero, ConfigError::kRxTimeout},
      {c.rx_timeout <= kRxTimeoutMax, ConfigError::kRxTimeoutMax},
      {c.ts_request_timeout > kZero, ConfigError::kTsRequestTimeout},
      {c.ts_request_timeout <= kTsRequestTimeoutMax, ConfigError::kTsRequestTimeoutMax},
      {c.rtd_sound_time >= kRtdSoundMin, ConfigError::kRtdSoundTimeMin},
      {c.rtd_sound_time <= kRtdSoundMax, ConfigError::kRtdSoundTimeMax},
  });
}

}  // namespace check

/// Refuses an all-zero, contradictory or unlawful configuration: bounds that a rule sets cannot be configured away.
[[nodiscard]] constexpr ConfigError config_check(const Config& c) {
  const ConfigError found[] = {check::channel(c.apps1, ConfigError::kApps1RangeMin),
                               check::channel(c.apps2, ConfigError::kApps2RangeMin),
                               check::pedals(c), check::request(c), check::ceilings(c), check::wheels(c),
                               check::times(c)};
  for (const ConfigError error : found) {
    if (error != ConfigError::kNone) return error;
  }
  return ConfigError::kNone;
}

static_assert(config_check(Config{}) == ConfigError::kNone, "the default configuration must pass its own check");

}  // namespace voltlap::master
