// SPDX-License-Identifier: Apache-2.0
// What follows from a car's numbers before it is driven: its pack, weight, force, speed, and what does not go together.
#pragma once
#include <string>
#include <vector>

#include "core/parameters.hpp"

namespace voltlap::plant {

struct CarSummary {
  double pack_full_v, pack_half_v, pack_empty_v;  ///< open-circuit at SOC 1 and 0.5; cells at their lowest voltage
  double capacity_ah, energy_kwh;                 ///< of the pack; the energy is that of its open-circuit voltage
  double pack_mass_kg;                            ///< cells x battery.mass_over_cells
  double car_mass_kg, total_mass_kg;              ///< with the pack; with the driver, too
  double discharge_max_a;                         ///< that the BMS allows
  double power_max_kw;                            ///< at half charge: what pack, limit and rules leave, at the bus
  double power_current_a;                         ///< pack current of master.power_max_kw, or power_max_kw, at half
  double wheel_force_n, wheel_grip_n;             ///< full torque from standstill; what the driven tyres hold of it
  double full_torque_mps;                         ///< speed up to which the torque stays within 5 % of its largest
  double top_speed_mps;                           ///< on a level road; 0: the car does not move
  std::string top_speed_by;                       ///< what ends it, in words
};

/// `car` as loaded, of an electric powertrain. Voltages and powers at the pack's initial temperature.
[[nodiscard]] CarSummary summarise_car(const VehicleParameters& car);

/// What would surprise on the track, each with the number to change; empty for most cars.
[[nodiscard]] std::vector<std::string> car_notes(const VehicleParameters& car, const CarSummary& summary);

/// Lines for people.
[[nodiscard]] std::string car_text(const VehicleParameters& car, const CarSummary& summary);

}  // namespace voltlap::plant
