// SPDX-License-Identifier: Apache-2.0
#include "bms/config.hpp"

#include "bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;

TEST_GROUP(BmsConfig) {
  Config config = pack_config();
  void refuse() {
    CHECK_FALSE(config_check(config));
    config = pack_config();
  }
};

TEST(BmsConfig, PackOfTheBenchIsAccepted) { CHECK(config_check(config)); }

// BMS-002
TEST(BmsConfig, UnsetPackIsRefused) { CHECK_FALSE(config_check(Config{})); }

TEST(BmsConfig, TooManyOrTooFewCellsAndSensorsAreRefused) {
  config.cells_in_series = 145;
  refuse();
  config.cells_in_series = 0;
  refuse();
  config.temperature_sensors = 37;
  refuse();
  config.temperature_sensors = 4;  // 20 % of 24 cells are 4.8
  refuse();
  config.temperature_sensors = 5;
  CHECK(config_check(config));
  config.capacity_mah = 0;
  refuse();
}

TEST(BmsConfig, VoltagesOutOfOrderAreRefused) {
  config.cell_voltage_trip_low = config.cell_voltage_min + CellVoltage::from_raw(1);
  refuse();
  config.cell_voltage_trip_high = config.cell_voltage_max - CellVoltage::from_raw(1);
  refuse();
  config.cell_voltage_max = config.cell_voltage_min;
  refuse();
}

TEST(BmsConfig, TablesThatDoNotRiseAreRefused) {
  config.ocv.voltage[1] = config.ocv.voltage[0];
  refuse();
  config.ocv.count = 33;
  refuse();
  config.ocv.count = 1;
  refuse();
  config.resistance.soc[1] = Soc{};
  refuse();
  config.resistance.resistance[0] = Resistance{};
  refuse();
}

TEST(BmsConfig, ValuesThatTheRulesForbidAreRefused) {
  config.temperature_trip = Temperature::from_raw(601);  // EV.7.5
  refuse();
  config.precharge_ratio = Ratio::from_raw(899'999);  // EV.5.6
  refuse();
  config.precharge_ratio = Ratio::from_raw(900'000);
  CHECK(config_check(config));
}

TEST(BmsConfig, CurrentsOutOfOrderAreRefused) {
  config.discharge_current_trip = config.discharge_current_max - Current::from_raw(1);
  refuse();
  config.discharge_current_max = Current{};
  refuse();
  config.limit_rise_per_s = Current{};
  refuse();
}
