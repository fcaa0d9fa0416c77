// SPDX-License-Identifier: Apache-2.0
#include "master/config.hpp"

#include <cstring>

#include "CppUTest/TestHarness.h"

using namespace voltlap;
using namespace voltlap::master;

namespace {

ConfigError check_with(void (*change)(Config&)) {
  Config c;
  change(c);
  return config_check(c);
}

}  // namespace

TEST_GROUP(MasterConfig){};

TEST(MasterConfig, DefaultIsAccepted) { CHECK(config_check(Config{}) == ConfigError::kNone); }

TEST(MasterConfig, AllZeroMemoryIsRefused) {
  Config c;
  std::memset(static_cast<void*>(&c), 0, sizeof c);
  CHECK(config_check(c) != ConfigError::kNone);
}

TEST(MasterConfig, RuleBoundsCannotBeConfiguredAway) {
  CHECK(check_with([](Config& c) { c.power_max_mw = 80'000'000; }) == ConfigError::kNone);
  CHECK(check_with([](Config& c) { c.power_max_mw = 80'000'001; }) == ConfigError::kPowerRule);
  CHECK(check_with([](Config& c) { c.apps_implausible_time = Duration::from_ms(101); }) ==
        ConfigError::kAppsImplausibleTimeRule);
  CHECK(check_with([](Config& c) { c.brake_sensor_fail_time = Duration::from_ms(101); }) ==
        ConfigError::kBrakeSensorFailTimeRule);
  CHECK(check_with([](Config& c) { c.rx_timeout = Duration::from_ms(51); }) == ConfigError::kRxTimeoutMax);
  CHECK(check_with([](Config& c) { c.rtd_sound_time = Duration::from_ms(999); }) == ConfigError::kRtdSoundTimeMin);
  CHECK(check_with([](Config& c) { c.rtd_sound_time = Duration::from_ms(1'000); }) == ConfigError::kNone);
  CHECK(check_with([](Config& c) { c.rtd_sound_time = Duration::from_ms(3'001); }) == ConfigError::kRtdSoundTimeMax);
  CHECK(check_with([](Config& c) { c.regen_speed_min = Speed::from_raw(1'388); }) == ConfigError::kRegenSpeedRule);
  CHECK(check_with([](Config& c) { c.apps_disagreement_max = Ratio::from_raw(100'001); }) ==
        ConfigError::kAppsDisagreementRule);
  CHECK(check_with([](Config& c) { c.brake_throttle_limit = Ratio::from_raw(250'001); }) ==
        ConfigError::kBrakeThrottleRule);
  CHECK(check_with([](Config& c) { c.pedal_release_level = Ratio::from_raw(50'001); }) ==
        ConfigError::kPedalReleaseRule);
}

TEST(MasterConfig, ContradictionsAreRefused) {
  CHECK(check_with([](Config& c) { c.apps1.full = c.apps1.released; }) == ConfigError::kApps1Full);
  CHECK(check_with([](Config& c) { c.apps2.range_min = c.apps2.released; }) == ConfigError::kApps2Released);
  CHECK(check_with([](Config& c) { c.regen_full_level = c.brake_pressed_level; }) == ConfigError::kRegenFull);
  CHECK(check_with([](Config& c) { c.phase_current_max = Current::from_raw(550'001); }) ==
        ConfigError::kPhaseCurrentRange);
  CHECK(check_with([](Config& c) { c.drive_efficiency = Ratio::from_raw(1'000'001); }) ==
        ConfigError::kDriveEfficiencyMax);
  CHECK(check_with([](Config& c) { c.pedal_at_half = Ratio::from_raw(249'999); }) == ConfigError::kPedalAtHalf);
  CHECK(check_with([](Config& c) { c.pedal_at_half = Ratio::from_raw(750'001); }) == ConfigError::kPedalAtHalfMax);
  CHECK(check_with([](Config& c) { c.brake_compare_level = c.brake_pressed_level; }) == ConfigError::kBrakeCompare);
  CHECK(check_with([](Config& c) { c.pack_resistance = Resistance::from_raw(-1); }) == ConfigError::kPackResistance);
  CHECK(check_with([](Config& c) { c.pack_resistance = Resistance::from_raw(5'000'001); }) ==
        ConfigError::kPackResistanceMax);
  CHECK(check_with([](Config& c) { c.limp_share = Ratio::from_raw(-1); }) == ConfigError::kLimpShare);
  CHECK(check_with([](Config& c) { c.limp_share = Ratio::from_raw(500'001); }) == ConfigError::kLimpShareMax);
  CHECK(check_with([](Config& c) { c.inverter_excess_max = Current{}; }) == ConfigError::kInverterExcess);
  CHECK(check_with([](Config& c) { c.inverter_excess_max = Current::from_raw(1'100'001); }) ==
        ConfigError::kInverterExcessMax);
  CHECK(check_with([](Config& c) { c.motor_derate_end = c.motor_derate_start; }) == ConfigError::kMotorDerating);
  CHECK(check_with([](Config& c) { c.battery_limit_on = Current{}; }) == ConfigError::kBatteryLimitOn);
}

TEST(MasterConfig, MotorsAtTheWheelsHaveLimitsOfTheirOwn) {
  CHECK(check_with([](Config& c) { c.motor_speed_max = MotorSpeed::from_raw(12'001); }) ==
        ConfigError::kMotorSpeedRange);
  CHECK(check_with([](Config& c) {
          c.inverter_protocol = InverterProtocol::kAmk;
          c.motor_speed_max = MotorSpeed::from_raw(20'000);
        }) == ConfigError::kNone);
  CHECK(check_with([](Config& c) {
          c.inverter_protocol = InverterProtocol::kAmk;
          c.motor_speed_max = MotorSpeed::from_raw(20'001);
        }) == ConfigError::kMotorSpeedRangeAmk);
  CHECK(check_with([](Config& c) { c.motor_current_max = Current{}; }) == ConfigError::kMotorCurrent);
  CHECK(check_with([](Config& c) { c.front_drive_share = Ratio::from_raw(-1); }) == ConfigError::kFrontDriveShare);
  CHECK(check_with([](Config& c) { c.front_drive_share = Ratio::from_raw(1'000'001); }) ==
        ConfigError::kFrontDriveShareMax);
  CHECK(check_with([](Config& c) { c.front_brake_share = Ratio::from_raw(-1); }) == ConfigError::kFrontBrakeShare);
  CHECK(check_with([](Config& c) { c.front_brake_share = Ratio::from_raw(1'000'001); }) ==
        ConfigError::kFrontBrakeShareMax);
  CHECK(check_with([](Config& c) { c.nominal_torque_mnm = 0; }) == ConfigError::kNominalTorque);
}
