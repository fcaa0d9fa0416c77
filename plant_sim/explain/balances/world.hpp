// SPDX-License-Identifier: Apache-2.0
// What a simulation of a log takes for true: the car with its battery, and what the sensors made of it.
#pragma once
#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "core/parameters.hpp"

namespace voltlap::plant {

/// reading(t) = (true(t - delay) (1 + gain)) + offset
struct SensorError {
  double gain = 0.0, offset = 0.0, delay_s = 0.0;
};

struct World {
  VehicleParameters car;
  SensorError current, voltage;      ///< `voltage`: of the cell or, with cells recorded, of the pack's own sensor
  double cells_late_s = 0.0;         ///< by which all cells were read before the time that the log has for them
  double cells_held = 0.0;           ///< share of the cells that are of another load than the row's, whichever it was
  double current_limit_a = 0.0;      ///< from here on readings end, and the voltage says what flowed; 0: nowhere
  double pack_resistance_ohm = 0.0;  ///< between cells and where the pack voltage is taken
  double published_compensation_ohm = 0.0;  ///< times I: added to the pack voltage that a battery unit publishes
  double published_tau_s = 0.0, published_filtered = 0.0;  ///< behind a filter, as is this share of the voltage
  double initial_soc_change = 0.0;
  std::vector<double> soc_after_gap;     ///< change of the SOC in each gap of the log; empty: none
  std::vector<double> warmth_after_gap;  ///< K by which the cells are warmer than their thermistors say, after each
  /// Currents of one cell [A] that its branches are charged by besides, where the log begins and after each gap.
  std::vector<std::array<double, kMostCellBranches>> charged_by_a;
  double initial_warmth_k = 0.0;      ///< by which the cells begin warmer than their thermistors say
  std::optional<double> reported_from_soc;  ///< whoever reports the SOC began there, whatever the true one was
  double reported_soc_low = 0.0;      ///< by which the SOC in the log begins below the true one
  bool soc_is_counted = false;  ///< the SOC in the log is the logged current over `counted_ah`, as a BMS counts
  double counted_ah = 0.0;      ///< of one cell
  double cooling_at_stop_change = 0.0;
  double thermistor_delay_s = 0.0, thermistor_offset_k = 0.0;  ///< of all thermistors
  double neighbour_heat = 0.0;
  // The car.
  double slope = 0.0, wind_mps = 0.0;
  double slip_change = 0.0, torque_change = 0.0, loss_change = 0.0;
  double friction_per_k = 0.0, torque_per_k = 0.0, base_speed_change = 0.0, regen_split = 0.0, grip_change = 0.0;
  double brake_change = 0.0;
};

}  // namespace voltlap::plant
