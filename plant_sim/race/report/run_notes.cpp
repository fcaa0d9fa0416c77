// SPDX-License-Identifier: Apache-2.0
#include "race/report/run_notes.hpp"

#include <algorithm>
#include <string_view>

#include <fmt/format.h>

#include "core/demand.hpp"
#include "race/report/run_text.hpp"

namespace voltlap::plant {
namespace {

bool is_set(const RunDescription& run, std::string_view key) {
  return std::any_of(run.settings.begin(), run.settings.end(), [key](const std::string& setting) {
    return setting.starts_with(key) && setting.substr(key.size()).starts_with('=');
  });
}

void note_pack(const RunDescription& run, const VehicleParameters& car, std::vector<std::string>& notes) {
  const bool other_pack =
      is_set(run, "battery.cell") || is_set(run, "battery.cells_in_series") || is_set(run, "battery.cells_in_parallel");
  if (other_pack && car.vehicle.mass_kg > 0.0) {
    notes.push_back(fmt::format("the car weighs {:g} kg with any pack (vehicle.mass_kg, as weighed); "
                                "vehicle.mass_without_pack_kg lets it follow the cells",
                                car.vehicle.mass_kg));
  }
  if (is_set(run, "battery.capacity_ah")) {
    notes.push_back("battery.capacity_ah changes the charge alone: the cells weigh, resist and warm as before");
  }
}

void note_motor(const RunDescription& run, const VehicleParameters& car, std::vector<std::string>& notes) {
  const double rotor = car.motor.rotor_inertia_kg_m2 * car.powertrain.final_drive * car.powertrain.final_drive;
  if (!is_set(run, "motor.model") || is_set(run, "powertrain.driveline_inertia_kg_m2") || rotor <= 0.0) return;
  notes.push_back(fmt::format("the new motor's rotor adds {:.2f} kg m2 at the wheels to the car's {:g} kg m2; where "
                              "those contain the old rotor, give powertrain.driveline_inertia_kg_m2 without it",
                              rotor, car.powertrain.driveline_inertia_kg_m2));
}

/// Cells between kinetic laws are known somewhat beyond their tables (car/battery/cell_tables.hpp).
void note_tables(const VehicleParameters& car, const EnduranceResult& r, std::vector<std::string>& notes) {
  const CellParameters& cell = car.cell;
  if (cell.temperature_breakpoints_c.empty() || cell.current_breakpoints_a.empty()) return;  // a car without a cell
  const double more_k = cell.kinetic_law ? 10.0 : 0.0, more_a = cell.kinetic_law ? 1.5 : 1.0;
  const double warmest = cell.temperature_breakpoints_c.back() + more_k;
  const double coldest = cell.temperature_breakpoints_c.front() - more_k;
  const double current = r.max_battery_current_a / car.battery.cells_in_parallel;
  const double most = cell.current_breakpoints_a.back() * more_a;
  VOLTLAP_DEMAND(warmest >= coldest);
  const auto held = [&](const std::string& reached, double end, const char* unit) {
    notes.push_back(fmt::format("{}, the tables of {} end at {:g} {}: their last values were taken", reached, cell.name,
                                end, unit));
  };
  if (r.max_battery_temp_c > warmest) {
    held(fmt::format("cells reached {:.1f} degC", r.max_battery_temp_c), warmest, "degC");
  }
  if (car.battery.initial_temperature_c < coldest) {
    held(fmt::format("cells began at {:.1f} degC", car.battery.initial_temperature_c), coldest, "degC");
  }
  if (most > 0.0 && current > most) held(fmt::format("a cell gave {:.1f} A", current), most, "A");
}

void note_beyond(const RunDescription& run, const VehicleParameters& car, const EnduranceResult& r,
                 std::vector<std::string>& notes) {
  if (r.beyond.cell_low_s > 0.0) {
    const double least_v = car.bms.cell_voltage_min_v.value_or(car.cell.voltage_min_v);
    notes.push_back(fmt::format("{} below the least voltage of {:g} V for {:.2f} s in all, down to {:.3f} V",
                                cells_alike(run, car) ? "the cells, all alike, were"
                                                      : fmt::format("some cell, at the lowest no. {}, was", r.min_cell),
                                least_v, r.beyond.cell_low_s, r.min_cell_voltage_v));
  }
  if (r.beyond.over_discharge_s > 0.0) {
    notes.push_back(fmt::format("the pack gave more than its BMS allowed for {:.2f} s in all, {:.1f} A more at most",
                                r.beyond.over_discharge_s, r.beyond.over_discharge_a));
  }
  if (r.beyond.link_falls > 0) {
    notes.push_back(fmt::format("the DC link fell below inverter.dc_voltage_min_v = {:g} V {}, where the inverter "
                                "switches off and the torque ends: no limit keeps above it; a smaller "
                                "master.power_max_kw or bms.discharge_current_max_a, or more battery.cells_in_series",
                                car.inverter.dc_voltage_min_v,
                                r.beyond.link_falls == 1 ? "once" : fmt::format("{} times", r.beyond.link_falls)));
  }
}

}  // namespace

std::vector<std::string> run_notes(const RunDescription& run, const VehicleParameters& car,
                                   const EnduranceResult& result) {
  std::vector<std::string> notes;
  note_beyond(run, car, result, notes);
  note_pack(run, car, notes);
  note_motor(run, car, notes);
  note_tables(car, result, notes);
  return notes;
}

}  // namespace voltlap::plant
