// SPDX-License-Identifier: Apache-2.0
// Everything about a pack that the BMS must be told. A const value: constexpr in an image, filled from files on a host.
#pragma once
#include <cstddef>
#include <cstdint>

#include "base/condition.hpp"
#include "base/inverter_protocol.hpp"
#include "base/time.hpp"
#include "base/units.hpp"
#include "bms/config_error.hpp"
#include "bms/curve_tables.hpp"

namespace voltlap::bms {

enum class SocMethod : std::uint8_t {
  kNone = 0,     ///< no state of charge; limits rest on voltage and the highest resistance of the table
  kCoulomb = 1,  ///< counted charge, started from the OCV at rest
  kEkf = 2,      ///< an extended Kalman filter of every cell; needs Config::branches
};

enum class LimitMethod : std::uint8_t {
  kEquation = 0,  ///< from the voltage now and one resistance
  kTable = 1,     ///< by temperature and state of charge
  kAhead = 2,     ///< what each cell can do for limit_horizon, by its own filter; needs SocMethod::kEkf
};

/// Times that a limit can be asked for; 0: for ever.
inline constexpr Duration kLimitHorizons[] = {Duration::from_ms(1'000), Duration::from_ms(10'000),
                                              Duration::from_ms(30'000), Duration::from_ms(0)};
inline constexpr std::size_t kLimitHorizonCount = sizeof(kLimitHorizons) / sizeof(kLimitHorizons[0]);

/// Fields without a value of their own belong to the pack and must be set; all-zero memory is refused by config_check.
struct Config {
  // pack
  std::uint16_t cells_in_series = 0;
  std::uint16_t temperature_sensors = 0;  ///< at least 20 % of the cells (EV.7.5)
  std::int32_t capacity_mah = 0;          ///< of one cell (parallel group), that is of the pack
  std::int32_t heat_capacity_j_per_k = 0; ///< of the same; 0: a limit that looks ahead counts no heat
  OcvTable ocv{};
  ResistanceTable resistance{};
  BranchTable branches{};

  // estimation
  SocMethod soc_method = SocMethod::kCoulomb;
  Current soc_start_current = Current::from_raw(1000);  ///< at most this much current when cells count as at rest

  // limits
  LimitMethod limit_method = LimitMethod::kEquation;
  Duration limit_horizon = Duration::from_ms(1'000);  ///< kAhead: one of kLimitHorizons
  CellVoltage cell_voltage_min = CellVoltage::from_raw(25'000);
  CellVoltage cell_voltage_max = CellVoltage::from_raw(42'000);
  Current discharge_current_max{};
  Current charge_current_max{};
  Current limit_rise_per_s = Current::from_raw(500'000);
  Temperature derating_start = Temperature::from_raw(550);  ///< limits fall linearly from here to zero at the trip
  Temperature charge_temperature_min = Temperature::from_raw(0);
  std::int32_t energy_to_go_m = 0;  ///< the charge is spread over this distance; 0 switches it off
  Soc energy_to_go_reserve = Soc::from_raw(30'000);  ///< that is to be left at its end
  std::int32_t um_per_motor_turn = 0;  ///< way of the car; needed for the distance alone
  Soc soc_derating_start{};  ///< discharge limit falls linearly from here to zero at SOC 0; 0 switches it off

  // trips: threshold and time
  CellVoltage cell_voltage_trip_low = CellVoltage::from_raw(24'000);
  CellVoltage cell_voltage_trip_high = CellVoltage::from_raw(42'500);
  Temperature temperature_trip = Temperature::from_raw(600);  ///< EV.7.5: below 60 degC
  Current discharge_current_trip{};
  Current charge_current_trip{};
  Ratio voltage_mismatch = Ratio::from_raw(50'000);  ///< of the pack voltage, against the sum of the cells
  Duration voltage_trip_time = Duration::from_ms(500);
  Duration temperature_trip_time = Duration::from_ms(1000);
  Duration measurement_lost_time = Duration::from_ms(500);  ///< since the last good sample
  Duration current_trip_time = Duration::from_ms(1000);
  Duration mismatch_time = Duration::from_ms(1000);
  Duration implausible_time = Duration::from_ms(1000);  ///< a channel that contradicts the others
  InverterProtocol inverter_protocol = InverterProtocol::kPhaseCurrent;
  std::int32_t motor_constant_unm_per_a = 0;  ///< torque a phase ampere; 0: current is not held against motor power

  // plausibility: outside of this a reading is a broken wire, not a voltage
  CellVoltage cell_voltage_plausible_min = CellVoltage::from_raw(5'000);
  CellVoltage cell_voltage_plausible_max = CellVoltage::from_raw(50'000);

  // contactors
  Ratio precharge_ratio = Ratio::from_raw(950'000);  ///< EV.5.6 asks 90 %, Formula Student 95 %
  Duration precharge_timeout = Duration::from_ms(5000);
  Duration precharge_time_min = Duration::from_ms(20);  ///< faster means that AIR+ is welded
  Duration precharge_time_unseen = Duration::from_ms(2000);  ///< when the DC link was up before and no rise is seen
  std::uint8_t precharge_attempts = 4;                       ///< in a row, then the resistor cools
  Duration precharge_cooling = Duration::from_ms(10'000);    ///< for each of them
  Duration opening_time = Duration::from_ms(100);            ///< at most, for the torque to go before the contactors
  Current opening_current = Current::from_raw(20'000);       ///< gone: low-voltage load and half as much again
  Duration contactor_time = Duration::from_ms(200);     ///< for an auxiliary contact to follow its command
  Duration contactor_drop_time = Duration::from_ms(20);  ///< open while active: less than it needs to close again
  Duration isolation_time = Duration::from_ms(100);     ///< that the isolation monitor reports before it trips
  Duration discharge_time = Duration::from_ms(5000);    ///< EV.5.4.5: DC link down after this
  Ratio dc_link_welded = Ratio::from_raw(500'000);      ///< DC link above this share of the pack: not disconnected

  // charge
  Current charger_current_max{};                                ///< 0: no charger in this pack
  CellVoltage charge_margin = CellVoltage::from_raw(50);        ///< below the maximum: error of a cell's channel
  Current charge_current_end = Current::from_raw(500);          ///< full when the voltage is held by no more
  // balancing
  CellVoltage balancing_voltage_min = CellVoltage::from_raw(39'000);
  CellVoltage balancing_difference = CellVoltage::from_raw(30);
  Current balancing_current_max = Current::from_raw(1000);
  Duration balancing_time_max = Duration::from_ms(86'400'000);  ///< of shunts in one charge
};

namespace check {

inline constexpr std::int32_t kCapacityMaxMah = 2'000'000;                  // 2000 Ah: 1.44e13 counts of charge
inline constexpr std::int32_t kHeatCapacityMax = 1'000'000;                        // [J/K] a tonne of cells; chosen
inline constexpr Temperature kTemperatureTripMax = Temperature::from_raw(600);  // EV.7.5
inline constexpr Ratio kPrechargeRatioMin = Ratio::from_raw(900'000);       // EV.5.6
inline constexpr Ratio kWhole = Ratio::from_raw(1'000'000);
inline constexpr CellVoltage kCellVoltageRange = CellVoltage::from_raw(65'000);     // of CellVoltages in car.dbc
inline constexpr Current kCurrentRange = Current::from_raw(1'000'000);              // of PackSensor in car.dbc
inline constexpr Current kLimitRiseMax = Current::from_raw(1'000'000'000);          // 1000 A in a millisecond
inline constexpr Current kSocStartCurrentMax = Current::from_raw(100'000);          // 100 A; chosen, no rest beyond
inline constexpr Current kOpeningCurrentMax = Current::from_raw(100'000);           // 100 A; chosen, contactors open it
inline constexpr Temperature kTemperatureRangeMin = Temperature::from_raw(-400);    // of Temperatures in car.dbc
inline constexpr Temperature kReferenceMax = Temperature::from_raw(1'000);          // 100 degC; chosen
inline constexpr std::int32_t kSlopeMaxPpm = 200'000;                               // 20 % a kelvin; chosen
inline constexpr std::int32_t kMotorConstantMinUnm = 1'000, kMotorConstantMaxUnm = 10'000'000;  // as in the master
inline constexpr std::int32_t kDistanceMinM = 1'000, kDistanceMaxM = 1'000'000;     // 1 to 1000 km; chosen
inline constexpr std::int32_t kMotorTurnMaxUm = 10'000'000;                         // 10 m; chosen
// Chosen: a fault that is seen this late does not protect the pack any more.
inline constexpr Duration kVoltageTripTimeMax = Duration::from_ms(5'000);
inline constexpr Duration kTemperatureTripTimeMax = Duration::from_ms(5'000);
inline constexpr Duration kMeasurementLostTimeMax = Duration::from_ms(2'000);
inline constexpr Duration kCurrentTripTimeMax = Duration::from_ms(10'000);
inline constexpr Duration kMismatchTimeMax = Duration::from_ms(10'000);
inline constexpr Duration kImplausibleTimeMax = Duration::from_ms(10'000);
inline constexpr Duration kContactorTimeMax = Duration::from_ms(2'000);
inline constexpr Duration kIsolationTimeMax = Duration::from_ms(5'000);             // the monitor's own delay is beside
inline constexpr Duration kDischargeTimeMax = Duration::from_ms(5'000);             // EV.5.4.5
inline constexpr Duration kPrechargeTimeMax = Duration::from_ms(60'000);
inline constexpr Duration kPrechargeCoolingMax = Duration::from_ms(600'000);
inline constexpr std::uint8_t kPrechargeAttemptsMax = 20;
inline constexpr Current kChargerCurrentMin = Current::from_raw(100);               // a step of ChargerCommand
inline constexpr CellVoltage kChargeMarginMax = CellVoltage::from_raw(2'000);       // 0.2 V; chosen
inline constexpr Duration kBalancingTimeMax = Duration::from_ms(864'000'000);       // 10 days; chosen
inline constexpr Duration kOpeningTimeMax = Duration::from_ms(100);                 // inside the 250 ms of EV.7.2.2

constexpr bool is_limit_horizon(Duration time) {
  for (const Duration known : kLimitHorizons) {
    if (time == known) return true;
  }
  return false;
}

constexpr ConfigError pack(const Config& c) {
  return first_broken<ConfigError>({
      {c.cells_in_series > 0 && c.cells_in_series <= kMaxCells, ConfigError::kCellsInSeries},
      {c.temperature_sensors > 0 && c.temperature_sensors <= kMaxTemperatures, ConfigError::kTemperatureSensors},
      {c.temperature_sensors * 5 >= c.cells_in_series, ConfigError::kTemperatureSensorsShare},  // EV.7.5: 20 %
      {c.capacity_mah > 0 && c.capacity_mah <= kCapacityMaxMah, ConfigError::kCapacity},
      {c.heat_capacity_j_per_k >= 0 && c.heat_capacity_j_per_k <= kHeatCapacityMax, ConfigError::kHeatCapacity},
      {c.soc_method == SocMethod::kNone || c.soc_method == SocMethod::kCoulomb || c.soc_method == SocMethod::kEkf,
       ConfigError::kSocMethod},
      {c.limit_method == LimitMethod::kEquation || c.limit_method == LimitMethod::kTable ||
           c.limit_method == LimitMethod::kAhead,
       ConfigError::kLimitMethod},
      {c.limit_method != LimitMethod::kAhead || c.soc_method == SocMethod::kEkf, ConfigError::kLimitMethodFilter},
      {is_limit_horizon(c.limit_horizon), ConfigError::kLimitHorizon},
  });
}

constexpr ConfigError energy_to_go(const Config& c) {
  return first_broken<ConfigError>({
      {c.energy_to_go_m == 0 || c.energy_to_go_m >= kDistanceMinM, ConfigError::kEnergyToGo},
      {c.energy_to_go_m <= kDistanceMaxM, ConfigError::kEnergyToGoMax},
      {c.energy_to_go_m == 0 || c.soc_method != SocMethod::kNone, ConfigError::kEnergyToGoSoc},
      {Soc{} <= c.energy_to_go_reserve, ConfigError::kEnergyReserve},
      {c.energy_to_go_reserve < kFull, ConfigError::kEnergyReserveFull},
      {c.energy_to_go_m == 0 || c.um_per_motor_turn > 0, ConfigError::kMotorTurn},
      {c.um_per_motor_turn <= kMotorTurnMaxUm, ConfigError::kMotorTurnMax},
  });
}

constexpr ConfigError branches(const Config& c) {
  if (c.soc_method != SocMethod::kEkf || !points_fit(c.resistance.count)) return ConfigError::kNone;
  const BranchTable& b = c.branches;
  const std::uint8_t n = c.resistance.count;
  return first_broken<ConfigError>({
      {resistances_fit(b.series, n) && resistances_fit(b.branch1, n) && resistances_fit(b.branch2, n),
       ConfigError::kBranchResistance},
      {times_fit(b.time1, n) && times_fit(b.time2, n), ConfigError::kBranchTime},
      {Current{} <= b.current_min && slopes_fit(b.per_ampere, (b.current_min - b.current_reference).raw(),
                                                (b.current_max - b.current_reference).raw()),
       ConfigError::kBranchSlopesCurrent},
      {warmth_fits(b, (b.current_min - b.current_reference).raw(), (b.current_max - b.current_reference).raw()),
       ConfigError::kBranchWarmth},
  });
}

/// The counts first: nothing is read beyond a table's end.
constexpr ConfigError tables(const Config& c) {
  if (!points_fit(c.ocv.count)) return ConfigError::kOcvPoints;
  if (!points_fit(c.resistance.count)) return ConfigError::kResistancePoints;
  return first_broken<ConfigError>({
      {spans_soc(c.ocv.soc, c.ocv.count), ConfigError::kOcvSoc},
      {c.ocv.voltage[0] > CellVoltage{} && strictly_increasing(c.ocv.voltage, c.ocv.count), ConfigError::kOcvVoltage},
      {spans_soc(c.resistance.soc, c.resistance.count), ConfigError::kResistanceSoc},
      {all_positive(c.resistance.resistance, c.resistance.count), ConfigError::kResistance},
      {kTemperatureRangeMin <= c.resistance.reference && c.resistance.reference <= kReferenceMax,
       ConfigError::kResistanceReference},
      {-kSlopeMaxPpm <= c.resistance.ppm_per_kelvin && c.resistance.ppm_per_kelvin <= kSlopeMaxPpm,
       ConfigError::kResistanceSlope},
  });
}

constexpr ConfigError voltages(const Config& c) {
  return first_broken<ConfigError>({
      {CellVoltage{} < c.cell_voltage_plausible_min, ConfigError::kVoltagePlausibleMin},
      {c.cell_voltage_plausible_min < c.cell_voltage_trip_low, ConfigError::kVoltageTripLowPlausible},
      {c.cell_voltage_trip_low <= c.cell_voltage_min, ConfigError::kVoltageMinTripLow},
      {c.cell_voltage_min < c.cell_voltage_max, ConfigError::kVoltageMaxMin},
      {c.cell_voltage_max <= c.cell_voltage_trip_high, ConfigError::kVoltageTripHighMax},
      {c.cell_voltage_trip_high < c.cell_voltage_plausible_max, ConfigError::kVoltagePlausibleMaxTripHigh},
      {c.cell_voltage_plausible_max <= kCellVoltageRange, ConfigError::kVoltagePlausibleMaxRange},
  });
}

constexpr ConfigError currents(const Config& c) {
  return first_broken<ConfigError>({
      {Current{} < c.discharge_current_max, ConfigError::kDischargeCurrentMax},
      {c.discharge_current_max <= c.discharge_current_trip, ConfigError::kDischargeCurrentTrip},
      {c.discharge_current_trip <= kCurrentRange, ConfigError::kDischargeCurrentTripRange},
      {Current{} <= c.charge_current_max, ConfigError::kChargeCurrentMax},
      {c.charge_current_max <= c.charge_current_trip, ConfigError::kChargeCurrentTrip},
      {Current{} < c.charge_current_trip, ConfigError::kChargeCurrentTripPositive},
      {c.charge_current_trip <= kCurrentRange, ConfigError::kChargeCurrentTripRange},
      {Current{} < c.limit_rise_per_s, ConfigError::kLimitRise},
      {c.limit_rise_per_s <= kLimitRiseMax, ConfigError::kLimitRiseMax},
      {Current{} <= c.soc_start_current, ConfigError::kSocStartCurrent},
      {c.soc_start_current <= kSocStartCurrentMax, ConfigError::kSocStartCurrentMax},
      {Current{} <= c.opening_current, ConfigError::kOpeningCurrent},
      {c.opening_current <= kOpeningCurrentMax, ConfigError::kOpeningCurrentMax},
      {c.motor_constant_unm_per_a == 0 || (c.motor_constant_unm_per_a >= kMotorConstantMinUnm &&
                                           c.motor_constant_unm_per_a <= kMotorConstantMaxUnm),
       ConfigError::kMotorConstant},
  });
}

constexpr ConfigError temperatures(const Config& c) {
  return first_broken<ConfigError>({
      {c.charge_temperature_min < c.derating_start, ConfigError::kChargeTemperatureMin},
      {kTemperatureRangeMin <= c.charge_temperature_min, ConfigError::kChargeTemperatureMinRange},
      {c.derating_start < c.temperature_trip, ConfigError::kDeratingStart},
      {c.temperature_trip <= kTemperatureTripMax, ConfigError::kTemperatureTripRule},
  });
}

constexpr ConfigError times(const Config& c) {
  constexpr Duration kZero{};
  return first_broken<ConfigError>({
      {kZero < c.voltage_trip_time, ConfigError::kVoltageTripTime},
      {c.voltage_trip_time <= kVoltageTripTimeMax, ConfigError::kVoltageTripTimeMax},
      {kZero < c.temperature_trip_time, ConfigError::kTemperatureTripTime},
      {c.temperature_trip_time <= kTemperatureTripTimeMax, ConfigError::kTemperatureTripTimeMax},
      {kZero < c.measurement_lost_time, ConfigError::kMeasurementLostTime},
      {c.measurement_lost_time <= kMeasurementLostTimeMax, ConfigError::kMeasurementLostTimeMax},
      {kZero < c.current_trip_time, ConfigError::kCurrentTripTime},
      {c.current_trip_time <= kCurrentTripTimeMax, ConfigError::kCurrentTripTimeMax},
      {kZero < c.mismatch_time, ConfigError::kMismatchTime},
      {c.mismatch_time <= kMismatchTimeMax, ConfigError::kMismatchTimeMax},
      {kZero < c.implausible_time, ConfigError::kImplausibleTime},
      {c.implausible_time <= kImplausibleTimeMax, ConfigError::kImplausibleTimeMax},
      {kZero < c.contactor_time, ConfigError::kContactorTime},
      {c.contactor_time <= kContactorTimeMax, ConfigError::kContactorTimeMax},
      {kZero <= c.contactor_drop_time, ConfigError::kContactorDropTime},
      {c.contactor_drop_time <= c.contactor_time, ConfigError::kContactorDropTimeMax},
      {kZero < c.isolation_time, ConfigError::kIsolationTime},
      {c.isolation_time <= kIsolationTimeMax, ConfigError::kIsolationTimeMax},
      {kZero < c.discharge_time, ConfigError::kDischargeTime},
      {c.discharge_time <= kDischargeTimeMax, ConfigError::kDischargeTimeRule},
      {kZero <= c.precharge_time_min, ConfigError::kPrechargeTimeMin},
      {c.precharge_time_min < c.precharge_timeout, ConfigError::kPrechargeTimeout},
      {c.precharge_timeout <= kPrechargeTimeMax, ConfigError::kPrechargeTimeoutMax},
      {kZero < c.precharge_time_unseen, ConfigError::kPrechargeTimeUnseen},
      {c.precharge_time_unseen <= kPrechargeTimeMax, ConfigError::kPrechargeTimeUnseenMax},
      {c.precharge_attempts > 0, ConfigError::kPrechargeAttempts},
      {c.precharge_attempts <= kPrechargeAttemptsMax, ConfigError::kPrechargeAttemptsMax},
      {kZero < c.precharge_cooling, ConfigError::kPrechargeCooling},
      {c.precharge_cooling <= kPrechargeCoolingMax, ConfigError::kPrechargeCoolingMax},
      {kZero <= c.opening_time, ConfigError::kOpeningTime},
      {c.opening_time <= kOpeningTimeMax, ConfigError::kOpeningTimeMax},
  });
}

constexpr ConfigError ratios(const Config& c) {
  return first_broken<ConfigError>({
      {kPrechargeRatioMin <= c.precharge_ratio, ConfigError::kPrechargeRatioRule},
      {c.precharge_ratio < kWhole, ConfigError::kPrechargeRatioWhole},
      {Ratio{} < c.voltage_mismatch, ConfigError::kVoltageMismatch},
      {c.voltage_mismatch < kWhole, ConfigError::kVoltageMismatchWhole},
      {Ratio{} < c.dc_link_welded, ConfigError::kDcLinkWelded},
      {c.dc_link_welded < c.precharge_ratio, ConfigError::kDcLinkWeldedPrecharge},
      {Soc{} <= c.soc_derating_start, ConfigError::kSocDeratingStart},
      {c.soc_derating_start < kFull, ConfigError::kSocDeratingStartFull},
  });
}

constexpr ConfigError balancing(const Config& c) {
  const bool charger = c.charger_current_max != Current{};
  return first_broken<ConfigError>({
      {!charger || kChargerCurrentMin <= c.charger_current_max, ConfigError::kChargerCurrent},
      {c.charger_current_max <= c.charge_current_trip, ConfigError::kChargerCurrentTrip},
      {CellVoltage{} <= c.charge_margin, ConfigError::kChargeMargin},
      {c.charge_margin <= kChargeMarginMax, ConfigError::kChargeMarginMax},
      {kChargerCurrentMin <= c.charge_current_end, ConfigError::kChargeCurrentEnd},
      {!charger || c.charge_current_end <= c.charger_current_max, ConfigError::kChargeCurrentEndMax},
      {CellVoltage{} <= c.balancing_voltage_min, ConfigError::kBalancingVoltageMin},
      {c.balancing_voltage_min <= c.cell_voltage_plausible_max, ConfigError::kBalancingVoltageMax},
      {CellVoltage{} <= c.balancing_difference, ConfigError::kBalancingDifference},
      {Current{} <= c.balancing_current_max, ConfigError::kBalancingCurrent},
      {Duration{} <= c.balancing_time_max, ConfigError::kBalancingTime},
      {c.balancing_time_max <= kBalancingTimeMax, ConfigError::kBalancingTimeMax},
  });
}

}  // namespace check

/// The first condition that does not hold; kNone when every value is inside its range and the limits stand in their
/// order. An image asserts it at compile time.
// BMS-002, BMS-070: a configuration that contradicts itself never closes a contactor.
[[nodiscard]] constexpr ConfigError config_check(const Config& config) {
  const ConfigError found[] = {check::pack(config), check::tables(config), check::branches(config),
                               check::voltages(config), check::currents(config), check::temperatures(config),
                               check::times(config), check::ratios(config), check::balancing(config),
                               check::energy_to_go(config)};
  for (const ConfigError error : found) {
    if (error != ConfigError::kNone) return error;
  }
  return ConfigError::kNone;
}
static_assert(config_check(Config{}) != ConfigError::kNone, "a pack that nobody described must be refused");

}  // namespace voltlap::bms
