// SPDX-License-Identifier: Apache-2.0
#include "bms/charge/charge_config.hpp"

#include "charge_bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;

TEST_GROUP(ChargeConfig) {
  Config config = charge_config();
};

TEST(ChargeConfig, TheHighestCellStaysAMarginBelowItsGreatestVoltage) {
  LONGS_EQUAL(41'950, charge_voltage(config).raw());
  config.charge_margin = CellVoltage{};
  LONGS_EQUAL(42'000, charge_voltage(config).raw());
}

TEST(ChargeConfig, ACellWhoseCurveEndsBelowIsFullAtItsEnd) {
  config.ocv.voltage[1] = CellVoltage::from_raw(34'000);
  LONGS_EQUAL(34'010, charge_voltage(config).raw());  // 0.5 A in 2 mOhm
}

TEST(ChargeConfig, TheChargersOwnBoundIsRoundedUp) {
  LONGS_EQUAL(1'008'000, charger_voltage_max(config).raw());
  config.cells_in_series = 1;
  config.cell_voltage_max = CellVoltage::from_raw(41'500);
  LONGS_EQUAL(42'000, charger_voltage_max(config).raw());
  config.cell_voltage_max = CellVoltage::from_raw(42'001);
  LONGS_EQUAL(43'000, charger_voltage_max(config).raw());
}
