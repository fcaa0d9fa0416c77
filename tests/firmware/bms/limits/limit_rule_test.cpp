// SPDX-License-Identifier: Apache-2.0
// What lowers a limit and what does not, on both sides of each bound; the method with tables beside its points.
#include <cmath>

#include "bms/limits/limits.hpp"
#include "bms/limits/table.hpp"

#include "bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;
using can::LimitReason;

TEST_GROUP(LimitRule) {
  Config config = pack_config();
  State s;
  void setup() override {
    config.charger_current_max = amps(20);
    for (std::size_t i = 0; i < 24; ++i) {
      s.measured.cell[i] = Sample<CellVoltage>{CellVoltage::from_raw(36'000), Instant{}, Quality::kGood};
    }
    s.measured.current.quality = Quality::kGood;
    s.pack.cells_good = s.pack.temperatures_good = s.soc.valid = true;
    s.pack.temperature_min = s.pack.temperature_max = Temperature::from_raw(250);
    s.soc.value = Soc::from_raw(500'000);
    s.cell_resistance = Resistance::from_raw(2'000);
    s.contactors.state = can::BmsState::kTsActive;
  }
  void expect_discharge(std::int32_t ma, LimitReason why) {
    const Limit limit = discharge_ceiling(config, s);
    LONGS_EQUAL(ma, limit.value.raw());
    LONGS_EQUAL(static_cast<int>(why), static_cast<int>(limit.reason));
  }
  void expect_charge(std::int32_t ma, LimitReason why) {
    const Limit limit = charge_ceiling(config, s);
    LONGS_EQUAL(ma, limit.value.raw());
    LONGS_EQUAL(static_cast<int>(why), static_cast<int>(limit.reason));
  }
};

// BMS-044
TEST(LimitRule, WithoutATemperatureOrAResistanceThereIsNoLimitButZero) {
  expect_discharge(500'000, LimitReason::kConfigMaximum);
  expect_charge(200'000, LimitReason::kConfigMaximum);
  s.pack.temperatures_good = false;
  expect_discharge(0, LimitReason::kMeasurementLost);
  expect_charge(0, LimitReason::kMeasurementLost);
  s.pack.temperatures_good = true;
  for (const std::int32_t uohm : {-1, 0}) {
    s.cell_resistance = Resistance::from_raw(uohm);
    expect_discharge(0, LimitReason::kMeasurementLost);
    expect_charge(0, LimitReason::kMeasurementLost);
  }
}

// BMS-051: why nothing is drawn on a charger, when something else forbids it, too.
TEST(LimitRule, AFaultOnAChargerIsAFault) {
  s.contactors.state = can::BmsState::kCharging;
  expect_discharge(0, LimitReason::kCharging);
  s.faults.open = true;
  expect_discharge(0, LimitReason::kFault);
}

// BMS-059: on a charger from 45 degC on, in a driving car from 55 degC on.
TEST(LimitRule, HeatLowersWhatAChargerMayGiveTenKelvinSooner) {
  struct Case {
    std::int32_t dc, charger_ma, drive_ma;
  };
  for (const Case& x : {Case{450, 20'000, 200'000}, Case{451, 19'800, 200'000}, Case{500, 10'000, 200'000},
                        Case{549, 200, 200'000}, Case{550, 0, 200'000}, Case{551, 0, 196'000}, Case{575, 0, 100'000}}) {
    s.pack.temperature_max = Temperature::from_raw(x.dc);
    s.contactors.state = can::BmsState::kCharging;
    expect_charge(x.charger_ma, x.dc > 450 ? LimitReason::kTemperature : LimitReason::kConfigMaximum);
    s.contactors.state = can::BmsState::kTsActive;
    expect_charge(x.drive_ma, x.dc > 550 ? LimitReason::kTemperature : LimitReason::kConfigMaximum);
  }
}

TEST(LimitRule, AnEmptyPackIsLimitedByItsChargeOnlyWhereThatIsAskedForAndKnown) {
  s.soc.value = Soc{};
  expect_discharge(500'000, LimitReason::kConfigMaximum);
  config.soc_derating_start = Soc::from_raw(100'000);
  expect_discharge(0, LimitReason::kSocLow);
  config.soc_method = SocMethod::kNone;
  s.soc.valid = false;
  expect_discharge(500'000, LimitReason::kConfigMaximum);
}

// BMS-048
TEST(LimitRule, TheEnergyToGoLowersTheDischargeLimitWhateverTheMethod) {
  for (const LimitMethod method : {LimitMethod::kEquation, LimitMethod::kTable}) {
    config.limit_method = method;
    s.energy_to_go.cap = amps(123);
    LONGS_EQUAL(123'000, discharge_ceiling(config, s).value.raw());
    expect_charge(200'000, LimitReason::kConfigMaximum);
  }
}

// BMS-040: rounded down, which of a whole number is itself.
TEST(LimitRule, AWholeQuotientBelowNothingIsItself) {
  s.measured.cell[5].value = CellVoltage::from_raw(25'000 - 2);  // 100 mA of 1 A
  s.measured.cell_current[5] = amps(1);
  expect_discharge(900, LimitReason::kCellVoltage);
}

// BMS-041
TEST(LimitRule, WhatIsNoCellOfThePackLimitsNoCharge) {
  s.measured.cell[24].value = CellVoltage::from_raw(60'000);
  expect_charge(200'000, LimitReason::kConfigMaximum);
}

namespace {

double between(double x, const std::initializer_list<std::pair<double, double>>& points) {
  auto left = points.begin();
  if (x <= left->first) return left->second;
  for (auto right = left + 1; right != points.end(); left = right++) {
    if (x <= right->first) {
      return left->second + (right->second - left->second) * (x - left->first) / (right->first - left->first);
    }
  }
  return left->second;
}

}  // namespace

// BMS-046
TEST(LimitRule, SharesOfTheTablesAreStraightBetweenTheirPointsAndHeldBeyond) {
  config.limit_method = LimitMethod::kTable;
  for (std::int32_t dc = -300; dc <= 440; dc += 7) {
    for (std::int32_t permille = 0; permille <= 1'000; permille += 25) {
      s.pack.temperature_min = s.pack.temperature_max = Temperature::from_raw(dc);
      s.soc.value = Soc::from_raw(1'000 * permille);
      const double by_cold = between(0.1 * dc, {{-20, 0.1}, {0, 0.4}, {10, 0.7}, {20, 1.0}});
      const double charge_by_cold = dc < 0 ? 0.0 : between(0.1 * dc, {{-20, 0.0}, {0, 0.1}, {10, 0.5}, {20, 1.0}});
      const double by_soc = between(1e-3 * permille, {{0, 0.1}, {0.2, 1.0}, {1, 1.0}});
      const double charge_by_soc = between(1e-3 * permille, {{0, 1.0}, {0.8, 1.0}, {1, 0.0}});
      DOUBLES_EQUAL(500'000 * std::min(by_cold, by_soc), discharge_ceiling(config, s).value.raw(), 2.0);
      DOUBLES_EQUAL(200'000 * std::min(charge_by_cold, charge_by_soc), charge_ceiling(config, s).value.raw(), 2.0);
    }
  }
}

// BMS-046: nothing in 1 s, and back in 10 s; at the bound, and 50 mV inside of it, neither.
TEST(LimitRule, ACapFallsBeyondTheBoundAndComesBackInsideOfIt) {
  config.limit_method = LimitMethod::kTable;
  s.pack.cells_good = true;
  struct Case {
    std::int32_t inside, discharge_ppm;
  };
  for (const Case& x : {Case{-1, 490'000}, Case{0, 500'000}, Case{499, 500'000}, Case{500, 501'000}}) {
    s.caps.discharge = s.caps.charge = Ratio::from_raw(500'000);
    s.pack.cell_min = config.cell_voltage_min + CellVoltage::from_raw(x.inside);
    s.pack.cell_max = config.cell_voltage_max - CellVoltage::from_raw(x.inside);
    follow_caps(config, Duration::from_ms(10), s);
    LONGS_EQUAL(x.discharge_ppm, s.caps.discharge.raw());
    LONGS_EQUAL(x.discharge_ppm, s.caps.charge.raw());
  }
  s.pack.cells_good = false;
  follow_caps(config, Duration::from_ms(10), s);
  LONGS_EQUAL(501'000, s.caps.discharge.raw());
  s.pack.cells_good = true;
  follow_caps(config, Duration::from_ms(60'000), s);
  LONGS_EQUAL(1'000'000, s.caps.discharge.raw());
  s.pack.cell_min = config.cell_voltage_min - CellVoltage::from_raw(1);
  follow_caps(config, Duration::from_ms(60'000), s);
  LONGS_EQUAL(0, s.caps.discharge.raw());
}
