// SPDX-License-Identifier: Apache-2.0
#include "bms/config.hpp"

#include "bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;

TEST_GROUP(BmsConfig) {
  Config config = pack_config();
  void refuse(ConfigError expected) {
    LONGS_EQUAL(static_cast<int>(expected), static_cast<int>(config_check(config)));
    config = pack_config();
  }
  [[nodiscard]] bool accepted() const { return config_check(config) == ConfigError::kNone; }
};

TEST(BmsConfig, PackOfTheBenchIsAccepted) { CHECK(accepted()); }

// BMS-002
TEST(BmsConfig, UnsetPackIsRefused) { CHECK(config_check(Config{}) == ConfigError::kCellsInSeries); }

TEST(BmsConfig, TooManyOrTooFewCellsAndSensorsAreRefused) {
  config.cells_in_series = 145;
  refuse(ConfigError::kCellsInSeries);
  config.cells_in_series = 0;
  refuse(ConfigError::kCellsInSeries);
  config.temperature_sensors = 37;
  refuse(ConfigError::kTemperatureSensors);
  config.temperature_sensors = 4;  // 20 % of 24 cells are 4.8
  refuse(ConfigError::kTemperatureSensorsShare);
  config.temperature_sensors = 5;
  CHECK(accepted());
  config.capacity_mah = 0;
  refuse(ConfigError::kCapacity);
}

TEST(BmsConfig, VoltagesOutOfOrderAreRefused) {
  config.cell_voltage_trip_low = config.cell_voltage_min + CellVoltage::from_raw(1);
  refuse(ConfigError::kVoltageMinTripLow);
  config.cell_voltage_trip_high = config.cell_voltage_max - CellVoltage::from_raw(1);
  refuse(ConfigError::kVoltageTripHighMax);
  config.cell_voltage_max = config.cell_voltage_min;
  refuse(ConfigError::kVoltageMaxMin);
}

TEST(BmsConfig, TablesThatDoNotRiseAreRefused) {
  config.ocv.voltage[1] = config.ocv.voltage[0];
  refuse(ConfigError::kOcvVoltage);
  config.ocv.count = 33;
  refuse(ConfigError::kOcvPoints);
  config.ocv.count = 1;
  refuse(ConfigError::kOcvPoints);
  config.resistance.soc[1] = Soc{};
  refuse(ConfigError::kResistanceSoc);
  config.resistance.resistance[0] = Resistance{};
  refuse(ConfigError::kResistance);
}

TEST(BmsConfig, ValuesThatTheRulesForbidAreRefused) {
  config.temperature_trip = Temperature::from_raw(601);  // EV.7.5
  refuse(ConfigError::kTemperatureTripRule);
  config.precharge_ratio = Ratio::from_raw(899'999);  // EV.5.6
  refuse(ConfigError::kPrechargeRatioRule);
  config.precharge_ratio = Ratio::from_raw(900'000);
  CHECK(accepted());
}

TEST(BmsConfig, CurrentsOutOfOrderAreRefused) {
  config.discharge_current_trip = config.discharge_current_max - Current::from_raw(1);
  refuse(ConfigError::kDischargeCurrentTrip);
  config.discharge_current_max = Current{};
  refuse(ConfigError::kDischargeCurrentMax);
  config.limit_rise_per_s = Current{};
  refuse(ConfigError::kLimitRise);
}
