// SPDX-License-Identifier: Apache-2.0
#include "car/powertrain/motor_voltage.hpp"

#include <fmt/format.h>

#include <cmath>

#include "car/battery/cell_tables.hpp"
#include "core/demand.hpp"
#include "core/errors.hpp"

namespace voltlap::plant {

void check_motor_voltage(const LoadedVehicle& vehicle) {
  const VehicleParameters& car = vehicle.parameters;
  const double most_v = car.motor.voltage_max_v;
  if (most_v == 0.0 || car.powertrain.kind != "electric") return;
  const double cell_v = CellTables(car.cell).ocv_v(1.0, car.battery.initial_temperature_c);
  const double pack_v = cell_v * car.battery.cells_in_series;
  VOLTLAP_DEMAND(std::isfinite(pack_v) && cell_v > 0.0);
  if (pack_v <= most_v) return;
  const auto origin = vehicle.origin.find("motor.voltage_max_v");
  std::string place = origin == vehicle.origin.end() ? "motor.voltage_max_v" : origin->second;
  if (!place.ends_with("motor.voltage_max_v")) place += ", motor.voltage_max_v";
  throw InputError(place,
                   fmt::format("a full pack of {:.1f} V ({} cells in series, {:.3f} V each)", pack_v,
                               car.battery.cells_in_series, cell_v),
                   fmt::format("at most {:g} V, which the motor bears", most_v),
                   fmt::format("Take at most {:.0f} for battery.cells_in_series, or a motor for more volts "
                               "(voltlap list motors)", std::floor(most_v / cell_v)));
}

}  // namespace voltlap::plant
