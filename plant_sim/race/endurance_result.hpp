// SPDX-License-Identifier: Apache-2.0
// What an endurance came to: how it ended, its laps, its extremes, its balances.
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "car/energy_ledger.hpp"
#include "race/limit_reason.hpp"
#include "race/time_to_safe_state.hpp"

namespace voltlap::plant {

struct LapRow {
  int lap;
  double time_s, energy_kwh, end_soc_pct, ledger_error_pct;
  double distance_m = 0.0;  ///< driven, not along the line
};

/// When each extreme of the result was first reached [s of the race].
struct ExtremeTimes {
  double battery_current_s = 0.0, speed_s = 0.0, pack_voltage_s = 0.0, cell_voltage_s = 0.0;
  double battery_temp_s = 0.0, motor_temp_s = 0.0, power_s = 0.0, power_mean_s = 0.0;
};

/// How far a race went beyond what its own BMS is set to.
struct BeyondLimits {
  double cell_low_s = 0.0;            ///< some cell stood below bms.cell_voltage_min_v, in all
  double over_discharge_s = 0.0;      ///< the pack gave more than any limit of the last 100 ms, by 2 % and 1 A
  double over_discharge_share = 0.0;  ///< at most so much of the limit more [1]
  double over_discharge_a = 0.0;      ///< at most so much more [A]
  int link_falls = 0;                 ///< times the DC link fell below what the inverter runs at, ready to drive
};

struct EnduranceResult {
  bool finished = false;
  bool stopped = false;  ///< it was interrupted
  double failure_time_s = 0.0;
  std::string failure_cause;
  double end_soc_pct = 0.0, max_battery_temp_c = 0.0, total_time_s = 0.0, max_battery_current_a = 0.0;
  double min_pack_voltage_v = 0.0, min_cell_voltage_v = 0.0;
  int min_cell = 0;  ///< from 1, where the lowest cell voltage was seen
  double max_speed_mps = 0.0, distance_m = 0.0;
  int laps = 0;  ///< completed
  double energy_out_kwh = 0.0;           ///< less what came back
  double energy_back_kwh = 0.0;          ///< into the terminals, in control periods in which more came than went
  double energy_ledger_error_pct = 0.0;  ///< worst lap
  double charge_balance_error_pct = 0.0;  ///< current integrated against SOC times capacity
  double bms_soc_error_pct = 0.0;  ///< largest difference of the firmware's SOC from the plant's
  bool bms_counts = false;         ///< it ever said its SOC: else there is no difference
  double max_motor_temp_c = 0.0;
  double max_power_w = 0.0;       ///< at the pack's terminals, of an integration step
  double max_power_mean_w = 0.0;  ///< of the moving mean over 500 ms, by control ticks
  double max_off_course_m = 0.0;  ///< farthest beside the line of the course
  ExtremeTimes extreme_times;
  BeyondLimits beyond;
  std::array<double, kLimitReasons> limit_active_s{};
  std::vector<LapRow> lap_rows;
  std::vector<LostNodeRow> lost_nodes;
  EnergyLedger ledger;
  std::uint32_t ticks = 0;
  std::uint64_t frames = 0;
  std::uint32_t frames_in_tick_max = 0;
};

}  // namespace voltlap::plant
