// SPDX-License-Identifier: Apache-2.0
// Everything about a pack that the BMS must be told. A const value: constexpr in an image, filled from files on a host.
#pragma once
#include <cstddef>
#include <cstdint>

#include "base/interpolate.hpp"
#include "base/time.hpp"
#include "base/units.hpp"
#include "can_dbc/car.hpp"

namespace voltlap::bms {

inline constexpr std::size_t kMaxCells = can::CellVoltages::kGroups * can::CellVoltages::kPerFrame;
inline constexpr std::size_t kMaxTemperatures = can::Temperatures::kGroups * can::Temperatures::kPerFrame;
inline constexpr std::size_t kMaxTablePoints = 32;
inline constexpr std::uint8_t kNoCell = 255;
static_assert(kMaxCells == 144 && kMaxCells < kNoCell, "a cell index must fit its byte on the bus");

/// Open-circuit voltage of one cell over state of charge; both columns strictly increasing.
struct OcvTable {
  Soc soc[kMaxTablePoints] = {};
  CellVoltage voltage[kMaxTablePoints] = {};
  std::uint8_t count = 0;
};

/// Resistance of one cell over state of charge at `reference`, and its slope with temperature:
///   R(soc, T) = R(soc) (1 + ppm_per_kelvin 1e-6 (T - reference)); a cell that is worse when cold has a negative slope
struct ResistanceTable {
  Soc soc[kMaxTablePoints] = {};
  Resistance resistance[kMaxTablePoints] = {};
  std::uint8_t count = 0;
  Temperature reference = Temperature::from_raw(250);
  std::int32_t ppm_per_kelvin = 0;
};

enum class SocMethod : std::uint8_t {
  kNone = 0,     ///< no state of charge; limits rest on voltage and the highest resistance of the table
  kCoulomb = 1,  ///< counted charge, started from the OCV at rest
};

/// Fields without a value of their own belong to the pack and must be set; all-zero memory is refused by config_check.
struct Config {
  // pack
  std::uint16_t cells_in_series = 0;
  std::uint16_t temperature_sensors = 0;  ///< at least 20 % of the cells (EV.7.5)
  std::int32_t capacity_mah = 0;          ///< of one cell (parallel group), that is of the pack
  OcvTable ocv{};
  ResistanceTable resistance{};

  // estimation
  SocMethod soc_method = SocMethod::kCoulomb;
  Current soc_start_current = Current::from_raw(1000);  ///< at most this much current when cells count as at rest

  // limits
  CellVoltage cell_voltage_min = CellVoltage::from_raw(25'000);
  CellVoltage cell_voltage_max = CellVoltage::from_raw(42'000);
  Current discharge_current_max{};
  Current charge_current_max{};
  Current limit_rise_per_s = Current::from_raw(500'000);
  Temperature derating_start = Temperature::from_raw(550);  ///< limits fall linearly from here to zero at the trip
  Temperature charge_temperature_min = Temperature::from_raw(0);
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

  // plausibility: outside of this a reading is a broken wire, not a voltage
  CellVoltage cell_voltage_plausible_min = CellVoltage::from_raw(5'000);
  CellVoltage cell_voltage_plausible_max = CellVoltage::from_raw(50'000);

  // contactors
  Ratio precharge_ratio = Ratio::from_raw(950'000);  ///< EV.5.6 asks 90 %, Formula Student 95 %
  Duration precharge_timeout = Duration::from_ms(5000);
  Duration precharge_time_min = Duration::from_ms(20);  ///< faster means that AIR+ is welded
  Duration contactor_time = Duration::from_ms(200);     ///< for an auxiliary contact to follow its command
  Duration contactor_drop_time = Duration::from_ms(20);  ///< open while active: less than it needs to close again
  Duration discharge_time = Duration::from_ms(5000);    ///< EV.5.4.5: DC link down after this
  Ratio dc_link_welded = Ratio::from_raw(500'000);      ///< DC link above this share of the pack: not disconnected

  // balancing
  CellVoltage balancing_voltage_min = CellVoltage::from_raw(39'000);
  CellVoltage balancing_difference = CellVoltage::from_raw(100);
  Current balancing_current_max = Current::from_raw(1000);
};

namespace check {

inline constexpr Soc kFull = Soc::from_raw(1'000'000);
inline constexpr std::int32_t kCapacityMaxMah = 2'000'000;  // keeps charge * 1e6 inside 64 bits

constexpr bool table_spans_soc(const Soc* soc, std::uint8_t count) {
  if (count < 2 || count > kMaxTablePoints) return false;
  return strictly_increasing(soc, count) && soc[0] >= Soc{} && soc[count - 1] <= kFull;
}

constexpr bool pack_ok(const Config& c) {
  if (c.cells_in_series == 0 || c.cells_in_series > kMaxCells) return false;
  if (c.temperature_sensors == 0 || c.temperature_sensors > kMaxTemperatures) return false;
  if (c.temperature_sensors * 5 < c.cells_in_series) return false;  // EV.7.5: 20 % of the cells
  return c.capacity_mah > 0 && c.capacity_mah <= kCapacityMaxMah;
}

constexpr bool tables_ok(const Config& c) {
  if (!table_spans_soc(c.ocv.soc, c.ocv.count) || !strictly_increasing(c.ocv.voltage, c.ocv.count)) return false;
  if (!table_spans_soc(c.resistance.soc, c.resistance.count)) return false;
  for (std::uint8_t i = 0; i < c.resistance.count; ++i) {
    if (c.resistance.resistance[i] <= Resistance{}) return false;
  }
  return c.ocv.voltage[0] > CellVoltage{};
}

/// plausible < trip low <= minimum < maximum <= trip high < plausible
constexpr bool voltages_in_order(const Config& c) {
  return CellVoltage{} < c.cell_voltage_plausible_min && c.cell_voltage_plausible_min < c.cell_voltage_trip_low &&
         c.cell_voltage_trip_low <= c.cell_voltage_min && c.cell_voltage_min < c.cell_voltage_max &&
         c.cell_voltage_max <= c.cell_voltage_trip_high && c.cell_voltage_trip_high < c.cell_voltage_plausible_max;
}

constexpr bool currents_in_order(const Config& c) {
  return Current{} < c.discharge_current_max && c.discharge_current_max <= c.discharge_current_trip &&
         Current{} <= c.charge_current_max && c.charge_current_max <= c.charge_current_trip &&
         Current{} < c.charge_current_trip && Current{} < c.limit_rise_per_s && Current{} <= c.soc_start_current;
}

constexpr bool temperatures_in_order(const Config& c) {
  constexpr Temperature kRuleMaximum = Temperature::from_raw(600);  // EV.7.5
  return c.charge_temperature_min < c.derating_start && c.derating_start < c.temperature_trip &&
         c.temperature_trip <= kRuleMaximum;
}

constexpr bool times_ok(const Config& c) {
  constexpr Duration kZero{};
  return kZero < c.voltage_trip_time && kZero < c.temperature_trip_time && kZero < c.measurement_lost_time &&
         kZero < c.current_trip_time && kZero < c.mismatch_time && kZero < c.contactor_time &&
         kZero <= c.contactor_drop_time && c.contactor_drop_time <= c.contactor_time && kZero < c.discharge_time &&
         kZero <= c.precharge_time_min && c.precharge_time_min < c.precharge_timeout;
}

constexpr bool ratios_ok(const Config& c) {
  constexpr Ratio kRuleMinimum = Ratio::from_raw(900'000);  // EV.5.6
  constexpr Ratio kWhole = Ratio::from_raw(1'000'000);
  return kRuleMinimum <= c.precharge_ratio && c.precharge_ratio < kWhole && Ratio{} < c.voltage_mismatch &&
         c.voltage_mismatch < kWhole && Ratio{} < c.dc_link_welded && c.dc_link_welded < c.precharge_ratio &&
         Soc{} <= c.soc_derating_start && c.soc_derating_start < kFull;
}

}  // namespace check

/// True when every value is inside its range and the limits stand in their order. An image asserts it at compile time.
// BMS-002: a configuration that contradicts itself never closes a contactor.
[[nodiscard]] constexpr bool config_check(const Config& config) {
  return check::pack_ok(config) && check::tables_ok(config) && check::voltages_in_order(config) &&
         check::currents_in_order(config) && check::temperatures_in_order(config) && check::times_ok(config) &&
         check::ratios_ok(config);
}
static_assert(!config_check(Config{}), "a pack that nobody described must be refused");

}  // namespace voltlap::bms
