// SPDX-License-Identifier: Apache-2.0
#include "explain/extend/extended_model.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <sstream>

#include "core/parameter_table.hpp"
#include "core/toml_text.hpp"

namespace voltlap::plant {
namespace {

/// Key and value of everything that differs.
std::map<std::string, std::string> changes(const VehicleParameters& from, const VehicleParameters& to) {
  std::map<std::string, std::string> before;
  VehicleParameters same = from;
  same.battery.cells.resize(std::max(from.battery.cells.size(), to.battery.cells.size()));
  for (const auto& [key, value] : parameter_values(same)) before[key] = value;
  std::map<std::string, std::string> out;
  for (const auto& [key, value] : parameter_values(to)) {
    if (before[key] != value) out[key] = value;
  }
  return out;
}

/// Sets a dotted key in a table, with the sections that it needs.
void put(toml::table& table, const std::string& key, const std::string& value) {
  toml::table* at = &table;
  std::size_t begin = 0;
  for (std::size_t dot = key.find('.'); dot != std::string::npos; begin = dot + 1, dot = key.find('.', begin)) {
    const std::string section = key.substr(begin, dot - begin);
    if (at->get(section) == nullptr) at->insert(section, toml::table{});
    at = at->get(section)->as_table();
  }
  toml::table parsed = toml::parse("x = " + value);
  parsed.get("x")->visit([&](const auto& node) { at->insert_or_assign(key.substr(begin), node); });
}

/// What no parameter of the plant can say.
struct Beyond {
  double World::* value;
  const char* what;
};
constexpr Beyond kBeyond[] = {{&World::slope, "the slope of the road"},
                              {&World::wind_mps, "wind"},
                              {&World::cooling_at_stop_change, "cooling at standstill"},
                              {&World::neighbour_heat, "heat between cells"},
                              {&World::friction_per_k, "brakes that fade"},
                              {&World::torque_per_k, "torque that falls with the motor's temperature"},
                              {&World::regen_split, "the share of regenerative braking"}};

/// A path beside the model's file stays right wherever the new file is put.
void keep_cell_path(const Model& model, toml::table& table) {
  const std::filesystem::path cell = std::filesystem::path(model.path).parent_path() / model.world.car.battery.cell;
  if (model.world.car.battery.cell.empty() || !std::filesystem::is_regular_file(cell)) return;
  put(table, "battery.cell", "\"" + std::filesystem::absolute(cell).string() + "\"");
}

}  // namespace

ExtendedCar extended_car(const World& given, const World& extended) {
  ExtendedCar out{extended.car, {}};
  VehicleParameters& car = out.car;
  if (extended.pack_resistance_ohm != given.pack_resistance_ohm) {
    car.battery.contact_resistance_ohm = std::max(0.0, extended.pack_resistance_ohm);
  }
  car.tyres.pacejka_b /= (1.0 + extended.slip_change) * (1.0 + extended.grip_change);
  car.tyres.pacejka_d *= 1.0 + extended.grip_change;
  car.motor.constant_nm_per_a *= 1.0 + extended.torque_change;
  for (double& torque : car.motor.curve_torque_nm) torque *= 1.0 + extended.torque_change;
  for (double& speed : car.motor.curve_speed_rpm) speed *= 1.0 + extended.base_speed_change;
  if (extended.loss_change != 0.0) {
    car.motor.winding_resistance_ohm *= 1.0 + extended.loss_change;
    car.inverter.efficiency = 1.0 / (1.0 + (1.0 + extended.loss_change) * (1.0 / car.inverter.efficiency - 1.0));
  }
  if (extended.thermistor_delay_s != given.thermistor_delay_s) {
    constexpr double kLongest = 600.0;  // s, as the cell file allows
    car.cell.surface_lag_s = std::clamp(car.cell.surface_lag_s + extended.thermistor_delay_s, 0.0, kLongest);
  }
  // Both say one number.
  if (car.cell.capacity_ah != given.car.cell.capacity_ah) car.battery.capacity_ah = car.cell.capacity_ah;
  if (car.cell.convection_w_per_m2_k != given.car.cell.convection_w_per_m2_k) {
    car.battery.convection_w_per_m2_k = car.cell.convection_w_per_m2_k;
  }
  for (const Beyond& beyond : kBeyond) {
    if (extended.*beyond.value != given.*beyond.value) out.left_out.emplace_back(beyond.what);
  }
  const SensorError &is = extended.current, &was = given.current;
  if (is.gain != was.gain || is.offset != was.offset || is.delay_s != was.delay_s ||
      extended.current_limit_a > 0.0) {
    out.left_out.emplace_back("the error of the current sensor");
  }
  return out;
}

std::string extended_model_toml(const Model& model, const VehicleParameters& car, const std::string& why) {
  auto changed = changes(model.world.car, car);
  const bool cell_file = model.kind == ModelKind::kCell;
  if (cell_file) std::erase_if(changed, [](const auto& entry) { return !entry.first.starts_with("cell."); });
  if (changed.empty()) return "";
  toml::table table;
  if (model.kind == ModelKind::kVehicle) {
    table.insert("base", std::filesystem::absolute(model.path).string());
  } else {
    table = parse_toml_file(model.path);
  }
  if (!cell_file) keep_cell_path(model, table);
  for (const auto& [key, value] : changed) put(table, cell_file ? key.substr(5) : key, value);
  std::ostringstream text;
  text << "# " << std::filesystem::path(model.path).filename().string() << " as extended by voltlap explain.\n# "
       << why << "\n"
       << table << "\n";
  return text.str();
}

}  // namespace voltlap::plant
