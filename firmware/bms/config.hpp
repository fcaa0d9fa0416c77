// SPDX-License-Identifier: Apache-2.0
// Everything about a pack that the BMS must be told. A const value: constexpr in an image, filled from files on a host.
#pragma once
#include <cstddef>
#include <cstdint>

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

/// True when every value is inside its range and the limits stand in their order; see config.cpp for the rules.
[[nodiscard]] bool config_check(const Config& config);

}  // namespace voltlap::bms
