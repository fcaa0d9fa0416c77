// SPDX-License-Identifier: Apache-2.0
#include "bms/config.hpp"

#include "bench.hpp"
#include "estimate/filter_bench.hpp"

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
  config.ocv.voltage[0] = CellVoltage{};
  refuse(ConfigError::kOcvVoltage);
  for (const SocMethod method : {SocMethod::kCoulomb, SocMethod::kEkf}) {  // whose circuit has as many points
    for (const std::uint8_t count : {std::uint8_t{0}, std::uint8_t{1}, std::uint8_t{33}, std::uint8_t{255}}) {
      config.soc_method = method;
      config.resistance.count = count;
      refuse(ConfigError::kResistancePoints);
    }
  }
  config.resistance.soc[1] = Soc{};
  refuse(ConfigError::kResistanceSoc);
  config.resistance.resistance[0] = Resistance{};
  refuse(ConfigError::kResistance);
}

// BMS-070
TEST(BmsConfig, TablesThatReachBeyondEmptyOrFullAreRefused) {
  config.ocv.soc[0] = Soc::from_raw(-1);
  refuse(ConfigError::kOcvSoc);
  config.ocv.soc[1] = Soc::from_raw(1'000'001);
  refuse(ConfigError::kOcvSoc);
  config.resistance.soc[0] = Soc::from_raw(-1);
  refuse(ConfigError::kResistanceSoc);
  config.resistance.soc[1] = Soc::from_raw(1'000'001);
  refuse(ConfigError::kResistanceSoc);
  config.ocv.soc[0] = config.resistance.soc[0] = Soc::from_raw(1);  // and need not reach them
  config.ocv.soc[1] = config.resistance.soc[1] = Soc::from_raw(999'999);
  CHECK(accepted());
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

namespace {

/// A field beyond each of its bounds, and at it, in the field's own counts.
struct Bound {
  ConfigError error;
  void (*put)(Config&, std::int32_t);
  std::int32_t beyond, at;
};

void put(Duration& field, std::int32_t counts) { field = Duration::from_ms(counts); }
void put(std::int32_t& field, std::int32_t counts) { field = counts; }
void put(std::uint8_t& field, std::int32_t counts) { field = static_cast<std::uint8_t>(counts); }
void put(SocMethod& field, std::int32_t counts) { field = static_cast<SocMethod>(counts); }
void put(LimitMethod& field, std::int32_t counts) { field = static_cast<LimitMethod>(counts); }
template <class Tag>
void put(Quantity<Tag>& field, std::int32_t counts) { field = Quantity<Tag>::from_raw(counts); }

template <auto Field>
Bound bound(ConfigError error, std::int32_t beyond, std::int32_t at) {
  return {error, [](Config& c, std::int32_t counts) { put(c.*Field, counts); }, beyond, at};
}
Bound reference(std::int32_t beyond, std::int32_t at) {
  return {ConfigError::kResistanceReference,
          [](Config& c, std::int32_t counts) { put(c.resistance.reference, counts); }, beyond, at};
}
Bound slope(std::int32_t beyond, std::int32_t at) {
  return {ConfigError::kResistanceSlope,
          [](Config& c, std::int32_t counts) { put(c.resistance.ppm_per_kelvin, counts); }, beyond, at};
}

using C = Config;
using E = ConfigError;
const Bound kBounds[] = {
    bound<&C::voltage_trip_time>(E::kVoltageTripTime, 0, 1),
    bound<&C::voltage_trip_time>(E::kVoltageTripTimeMax, 5'001, 5'000),
    bound<&C::temperature_trip_time>(E::kTemperatureTripTime, 0, 1),
    bound<&C::temperature_trip_time>(E::kTemperatureTripTimeMax, 5'001, 5'000),
    bound<&C::measurement_lost_time>(E::kMeasurementLostTime, 0, 1),
    bound<&C::measurement_lost_time>(E::kMeasurementLostTimeMax, 2'001, 2'000),
    bound<&C::current_trip_time>(E::kCurrentTripTime, 0, 1),
    bound<&C::current_trip_time>(E::kCurrentTripTimeMax, 10'001, 10'000),
    bound<&C::mismatch_time>(E::kMismatchTime, 0, 1),
    bound<&C::mismatch_time>(E::kMismatchTimeMax, 10'001, 10'000),
    bound<&C::implausible_time>(E::kImplausibleTime, 0, 1),
    bound<&C::implausible_time>(E::kImplausibleTimeMax, 10'001, 10'000),
    bound<&C::contactor_time>(E::kContactorTime, 0, 20),
    bound<&C::contactor_time>(E::kContactorTimeMax, 2'001, 2'000),
    bound<&C::contactor_drop_time>(E::kContactorDropTime, -1, 0),
    bound<&C::contactor_drop_time>(E::kContactorDropTimeMax, 201, 200),
    bound<&C::isolation_time>(E::kIsolationTime, 0, 1),
    bound<&C::isolation_time>(E::kIsolationTimeMax, 5'001, 5'000),
    bound<&C::discharge_time>(E::kDischargeTime, 0, 1),
    bound<&C::discharge_time>(E::kDischargeTimeRule, 5'001, 5'000),
    bound<&C::precharge_time_min>(E::kPrechargeTimeMin, -1, 0),
    bound<&C::precharge_timeout>(E::kPrechargeTimeout, 20, 21),
    bound<&C::precharge_timeout>(E::kPrechargeTimeoutMax, 60'001, 60'000),
    bound<&C::precharge_time_unseen>(E::kPrechargeTimeUnseen, 0, 1),
    bound<&C::precharge_time_unseen>(E::kPrechargeTimeUnseenMax, 60'001, 60'000),
    bound<&C::precharge_attempts>(E::kPrechargeAttempts, 0, 1),
    bound<&C::precharge_attempts>(E::kPrechargeAttemptsMax, 21, 20),
    bound<&C::precharge_cooling>(E::kPrechargeCooling, 0, 1),
    bound<&C::precharge_cooling>(E::kPrechargeCoolingMax, 600'001, 600'000),
    bound<&C::opening_time>(E::kOpeningTime, -1, 0),
    bound<&C::opening_time>(E::kOpeningTimeMax, 101, 100),
    bound<&C::opening_current>(E::kOpeningCurrent, -1, 0),
    bound<&C::opening_current>(E::kOpeningCurrentMax, 100'001, 100'000),
    bound<&C::motor_constant_unm_per_a>(E::kMotorConstant, 999, 1'000),
    bound<&C::motor_constant_unm_per_a>(E::kMotorConstant, 10'000'001, 10'000'000),
    bound<&C::motor_constant_unm_per_a>(E::kMotorConstant, -1, 0),
    bound<&C::soc_method>(E::kSocMethod, 3, 0),
    bound<&C::limit_method>(E::kLimitMethod, 3, 1),
    bound<&C::limit_method>(E::kLimitMethodFilter, 2, 0),  // ahead, with a count
    bound<&C::limit_horizon>(E::kLimitHorizon, 2'000, 10'000),
    bound<&C::limit_horizon>(E::kLimitHorizon, 1, 0),
    reference(-401, -400),
    reference(1'001, 1'000),
    slope(200'001, 200'000),
    slope(-200'001, -200'000),
    bound<&C::cell_voltage_plausible_max>(E::kVoltagePlausibleMaxRange, 65'001, 65'000),
    bound<&C::discharge_current_trip>(E::kDischargeCurrentTripRange, 1'000'001, 1'000'000),
    bound<&C::charge_current_trip>(E::kChargeCurrentTripRange, 1'000'001, 1'000'000),
    bound<&C::limit_rise_per_s>(E::kLimitRiseMax, 1'000'000'001, 1'000'000'000),
    bound<&C::soc_start_current>(E::kSocStartCurrent, -1, 0),
    bound<&C::soc_start_current>(E::kSocStartCurrentMax, 100'001, 100'000),
    bound<&C::charge_temperature_min>(E::kChargeTemperatureMinRange, -401, -400),
    bound<&C::balancing_voltage_min>(E::kBalancingVoltageMin, -1, 0),
    bound<&C::balancing_voltage_min>(E::kBalancingVoltageMax, 50'001, 50'000),
    bound<&C::balancing_difference>(E::kBalancingDifference, -1, 0),
    bound<&C::balancing_current_max>(E::kBalancingCurrent, -1, 0),
    bound<&C::balancing_time_max>(E::kBalancingTime, -1, 0),
    bound<&C::balancing_time_max>(E::kBalancingTimeMax, 864'000'001, 864'000'000),
    bound<&C::charge_margin>(E::kChargeMargin, -1, 0),
    bound<&C::charge_margin>(E::kChargeMarginMax, 2'001, 2'000),
    bound<&C::charge_current_end>(E::kChargeCurrentEnd, 99, 100),
    bound<&C::charger_current_max>(E::kChargerCurrent, 99, 500),
    bound<&C::charger_current_max>(E::kChargerCurrent, -1, 0),
    bound<&C::charger_current_max>(E::kChargerCurrentTrip, 300'001, 300'000),
    bound<&C::charger_current_max>(E::kChargeCurrentEndMax, 499, 500),
    bound<&C::energy_to_go_reserve>(E::kEnergyReserve, -1, 0),
    bound<&C::energy_to_go_reserve>(E::kEnergyReserveFull, 1'000'000, 999'999),
    bound<&C::um_per_motor_turn>(E::kMotorTurnMax, 10'000'001, 10'000'000),
    bound<&C::capacity_mah>(E::kCapacity, 2'000'001, 2'000'000),
    bound<&C::heat_capacity_j_per_k>(E::kHeatCapacity, -1, 0),
    bound<&C::heat_capacity_j_per_k>(E::kHeatCapacity, 1'000'001, 1'000'000),
};

}  // namespace

// BMS-070
TEST(BmsConfig, EveryBoundRefusesWhatIsBeyondItAndAcceptsWhatIsAtIt) {
  for (const Bound& bound : kBounds) {
    bound.put(config, bound.beyond);
    refuse(bound.error);
    bound.put(config, bound.at);
    refuse(ConfigError::kNone);
  }
}

// BMS-070
TEST(BmsConfig, ADistanceNeedsAStateOfChargeAndTheWayOfATurn) {
  struct Told {
    std::int32_t metres, turn_um;
    SocMethod soc;
    ConfigError error;
  };
  for (const Told& told : {Told{1'000, 1, SocMethod::kCoulomb, E::kNone},
                           {999, 1, SocMethod::kCoulomb, E::kEnergyToGo},
                           {-1, 1, SocMethod::kCoulomb, E::kEnergyToGo},
                           {1'000'000, 1, SocMethod::kCoulomb, E::kNone},
                           {1'000'001, 1, SocMethod::kCoulomb, E::kEnergyToGoMax},
                           {22'000, 0, SocMethod::kCoulomb, E::kMotorTurn},
                           {22'000, 1, SocMethod::kNone, E::kEnergyToGoSoc},
                           {0, 0, SocMethod::kNone, E::kNone}}) {
    config.energy_to_go_m = told.metres;
    config.um_per_motor_turn = told.turn_um;
    config.soc_method = told.soc;
    refuse(told.error);
  }
}

// BMS-070
TEST(BmsConfig, TheFiltersCircuitIsCheckedWhereThereIsAFilter) {
  const Config good = filtered_config();
  CHECK(config_check(good) == ConfigError::kNone);
  const auto refused = [&](ConfigError expected, const auto& change) {
    config = good;
    change(config);
    refuse(expected);
    config = good;
    change(config);
    config.soc_method = SocMethod::kCoulomb;  // that reads nothing of it
    CHECK(accepted());
  };
  using E = ConfigError;
  refused(E::kBranchResistance, [](Config& c) { c.branches.series[1] = Resistance::from_raw(-1); });
  refused(E::kBranchResistance, [](Config& c) { c.branches.branch1[0] = Resistance::from_raw(-1); });
  refused(E::kBranchResistance, [](Config& c) { c.branches.branch2[2] = Resistance::from_raw(500'001); });
  refused(E::kBranchTime, [](Config& c) { c.branches.time1[2] = Duration::from_ms(499); });
  refused(E::kBranchTime, [](Config& c) { c.branches.time2[0] = Duration::from_ms(100'000'001); });
  refused(E::kBranchSlopesCurrent, [](Config& c) { c.branches.current_min = amps(-1); });
  refused(E::kBranchSlopesCurrent, [](Config& c) { c.branches.current_min = amps(301); });
  refused(E::kBranchSlopesCurrent, [](Config& c) { c.branches.per_ampere.time1 = -3'604; });  // at 300 A 1 - 0.901
  refused(E::kBranchSlopesCurrent, [](Config& c) { c.branches.per_ampere.branch2 = 7'204; });  // at 300 A 1 + 1.801
  refused(E::kBranchSlopesCurrent, [](Config& c) { c.branches.per_ampere.branch2 = -100'001; });
  refused(E::kBranchWarmth, [](Config& c) { c.branches.warmth_count = 0; });
  refused(E::kBranchWarmth, [](Config& c) { c.branches.warmth_count = 13; });
  refused(E::kBranchWarmth, [](Config& c) { c.branches.warmth_at[1] = Temperature::from_raw(9); });
  refused(E::kBranchWarmth, [](Config& c) { c.branches.warmth_at[1] = Temperature::from_raw(3'001); });
  refused(E::kBranchWarmth, [](Config& c) { c.branches.warmth_at[0] = Temperature::from_raw(-1'001); });
  refused(E::kBranchWarmth, [](Config& c) { c.branches.warmth[0].series = 99'999; });
  refused(E::kBranchWarmth, [](Config& c) { c.branches.warmth[1].branch1 = 99'999; });
  // What the current makes of it at most, at 0 A, beside it: 1 + 0.0003 x 50, 1 + 0.0015 x 50, 1, 1 + 0.001 x 50, 1.
  refused(E::kBranchWarmth, [](Config& c) { c.branches.warmth[0].series = 7'783'253; });
  refused(E::kBranchWarmth, [](Config& c) { c.branches.warmth[0].branch1 = 7'348'839; });
  refused(E::kBranchWarmth, [](Config& c) { c.branches.warmth[0].branch2 = 7'900'001; });
  refused(E::kBranchWarmth, [](Config& c) { c.branches.warmth[0].time1 = 7'523'811; });
  refused(E::kBranchWarmth, [](Config& c) { c.branches.warmth[1].time2 = 7'900'001; });
}

// BMS-070
TEST(BmsConfig, TheFiltersCircuitIsAcceptedAtItsBounds) {
  config = filtered_config();
  config.branches.branch2[0] = Resistance::from_raw(500'000);
  config.branches.time1[0] = Duration::from_ms(500);
  config.branches.time2[0] = Duration::from_ms(100'000'000);
  config.branches.per_ampere.time1 = -3'600;
  config.branches.per_ampere.branch2 = 7'200;
  CHECK(accepted());
  config = filtered_config();
  config.branches.warmth[0] = {7'783'252, 7'348'838, 7'900'000, 7'523'810, 7'900'000};
  config.branches.warmth[1] = {100'000, 100'000, 100'000, 100'000, 100'000};
  for (const std::int32_t second : {10, 3'000}) {
    config.branches.warmth_at[1] = Temperature::from_raw(second);
    CHECK(accepted());
  }
  config.branches.warmth_at[0] = Temperature::from_raw(-1'000);
  CHECK(accepted());
  config.branches.warmth_count = 1;
  CHECK(accepted());
  config.branches.warmth_count = kMaxWarmthPoints;
  for (std::size_t i = 0; i < kMaxWarmthPoints; ++i)
    config.branches.warmth_at[i] = Temperature::from_raw(static_cast<std::int32_t>(10 * i));
  CHECK(accepted());
}
