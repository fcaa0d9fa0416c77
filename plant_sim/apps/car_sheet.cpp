// SPDX-License-Identifier: Apache-2.0
#include "apps/car_sheet.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>

#include "car/powertrain/motor_voltage.hpp"
#include "core/demand.hpp"
#include "core/parameter_table.hpp"
#include "core/toml_text.hpp"

namespace voltlap::plant {
namespace {

namespace fs = std::filesystem;

struct SheetNumber {
  std::string_view key, words;
};

/// The numbers of the sheet, in the order in which a team knows them; each section once.
constexpr SheetNumber kSheet[] = {
    {"vehicle.mass_without_pack_kg", "car without driver and pack"},
    {"vehicle.mass_kg", "car without driver, the same with any pack"},
    {"vehicle.driver_mass_kg", "driver with equipment"},
    {"vehicle.cg_rear_fraction", "share of the weight on the rear axle"},
    {"vehicle.cg_height_m", "centre of gravity, with driver"},
    {"vehicle.wheelbase_m", "between the axles"},
    {"vehicle.track_front_m", "between the front wheels"},
    {"vehicle.track_rear_m", "between the rear wheels"},
    {"tyres.radius_m", "rolling radius under load"},
    {"tyres.lap_radius_m", "that of the lap solver"},
    {"tyres.pacejka_d", "grip: peak force over load"},
    {"tyres.rolling_resistance", "drag of rolling over load"},
    {"tyres.cornering_stiffness_per_rad", "drag of cornering, 0: none"},
    {"powertrain.final_drive", "motor turns per wheel turn"},
    {"powertrain.driveline_efficiency", "of the torque, motor to wheels"},
    {"powertrain.driveline_inertia_kg_m2", "what turns with the rear wheels"},
    {"motor.model", "voltlap list motors, or a file"},
    {"inverter.current_max_a", "phase current"},
    {"inverter.efficiency", "DC to motor"},
    {"inverter.dc_voltage_min_v", "off below it"},
    {"battery.cell", "voltlap list cells, or a file"},
    {"battery.cells_in_series", "cells, or groups of cells, in series"},
    {"battery.cells_in_parallel", "cells in a group"},
    {"battery.mass_over_cells", "mass of the pack over that of its cells"},
    {"battery.initial_temperature_c", "cells at the start"},
    {"aero.drag_coefficient", "times the area"},
    {"aero.downforce_coefficient", "times the area, above 0 presses down"},
    {"aero.frontal_area_m2", "of both coefficients"},
    {"brakes.force_scale", "on both calipers"},
    {"low_voltage.power_w", "from the DC link"},
    {"master.power_max_kw", "at the DC link, the rules allow 80"},
    {"master.regen_current_max_a", "phase current of full regeneration, 0: none"},
    {"bms.discharge_current_max_a", "largest that the BMS allows"},
    {"bms.charge_current_max_a", "largest that the BMS allows"},
    {"bms.charger_current_max_a", "largest that the BMS asks of a charger"},
    {"sensors.temperature_count", "thermistors"},
    {"contactors.dc_link_capacitance_f", "DC link"},
    {"contactors.bleed_resistance_ohm", "across the DC link"},
    {"contactors.precharge_resistance_ohm", "into the DC link"},
    {"environment.ambient_c", "air"},
    {"assertions.battery_temperature_max_c", "a hotter cell fails the run"},
};

/// Lines that only some cars have.
bool has_line(std::string_view key, const VehicleParameters& car) {
  if (key == "vehicle.mass_kg") return car.vehicle.mass_kg > 0.0;
  if (key == "vehicle.mass_without_pack_kg") return car.vehicle.mass_without_pack_kg > 0.0;
  if (key == "tyres.lap_radius_m") return car.tyres.lap_radius_m != car.tyres.radius_m;
  return key != "motor.model" || !car.motor.model.empty();
}

std::string section_of(std::string_view key) { return std::string(key.substr(0, key.find('.'))); }

/// A name of the data folder stays; a path becomes one that holds from the sheet's folder.
std::string name_from(const DataFolder& data, const std::string& kind, const std::string& name,
                      const std::string& place, const std::string& file) {
  const std::vector<std::string> known = data.names(kind);
  if (std::find(known.begin(), known.end(), name) != known.end()) return name;
  const fs::path folder = fs::weakly_canonical(fs::absolute(file)).parent_path();
  return fs::weakly_canonical(data.find(kind, name, place)).lexically_proximate(folder).string();
}

/// One line a key, a section's lines together.
class SheetWriter {
 public:
  explicit SheetWriter(std::string head) : text_(std::move(head)) {}

  void section(const std::string& name) { text_ += fmt::format("\n[{}]\n", name); }
  void line(std::string_view key, const std::string& value, const std::string& comment) {
    const std::string statement = fmt::format("{} = {}", key.substr(key.find('.') + 1), value);
    text_ += fmt::format("{:<36} # {}\n", statement, comment);
    ++numbers_;
  }
  void remark(const std::string& text) { text_ += fmt::format("# {}\n", text); }

  std::size_t numbers_ = 0;
  std::string text_;
};

/// What the sheet says behind a value: unit, meaning; where it is from.
class Comments {
 public:
  Comments(const GivenKeys& given, const std::vector<DerivedNumber>& derived, std::string base)
      : given_(given), base_(std::move(base)) {
    for (const DerivedNumber& number : derived) why_[number.key] = number.why;
  }
  [[nodiscard]] std::string of(const ParameterRow& row) const {
    const auto* line = std::find_if(std::begin(kSheet), std::end(kSheet),
                                    [&](const SheetNumber& number) { return number.key == row.key; });
    const std::string_view words = line == std::end(kSheet) ? row.description : line->words;
    const std::string unit = row.unit == "-" ? "" : std::string(row.unit) + ", ";
    return fmt::format("{}{}; {}", unit, words, source(std::string(row.key)));
  }

 private:
  [[nodiscard]] std::string source(const std::string& key) const {
    if (given_.contains(key)) return "yours";
    const auto derived = why_.find(key);
    return derived != why_.end() ? derived->second : "as " + base_;
  }

  const GivenKeys& given_;
  std::map<std::string, std::string, std::less<>> why_;
  std::string base_;
};

/// The keys of the sheet's section that the car has, then what else the team gave there.
std::vector<std::string> keys_of(const std::string& section, const GivenKeys& given, const VehicleParameters& car) {
  std::vector<std::string> keys;
  for (const SheetNumber& number : kSheet) {
    if (section_of(number.key) == section && has_line(number.key, car)) keys.emplace_back(number.key);
  }
  for (const std::string& key : given) {
    if (section_of(key) == section && std::find(keys.begin(), keys.end(), key) == keys.end()) keys.push_back(key);
  }
  return keys;
}

std::vector<std::string> sections(const GivenKeys& given) {
  std::vector<std::string> out;
  const auto add = [&out](std::string_view key) {
    const std::string section = section_of(key);
    if (std::find(out.begin(), out.end(), section) == out.end()) out.push_back(section);
  };
  for (const SheetNumber& number : kSheet) add(number.key);
  for (const std::string& key : given) add(key);
  return out;
}

std::string quoted(const std::string& word) { return '"' + word + '"'; }

}  // namespace

CarSheet make_car_sheet(const DataFolder& data, const CarRequest& request, const std::string& file) {
  const LoadedVehicle base = load_vehicle(data, request.from);
  std::vector<std::string> settings = request.settings;
  GivenKeys given;
  std::map<std::string, std::string> as_given;  // of keys with a number (battery.cells.3.leak_a): no row has them
  for (const std::string& setting : settings) {
    const Setting parsed = parse_setting(setting);
    given.insert(parsed.key);
    as_given[parsed.key] = found_text(*parsed.value);
  }
  const LoadedVehicle asked = load_vehicle(data, request.from, settings);

  CarSheet sheet;
  const auto apply = [&](std::vector<DerivedNumber> numbers) {
    for (DerivedNumber& number : numbers) {
      settings.push_back(number.key + "=" + number.value);
      sheet.derived.push_back(std::move(number));
    }
    sheet.car = load_vehicle(data, request.from, settings);
  };
  check_motor_voltage(asked);
  apply(derive_mass(base.parameters, asked.parameters, given, request.mass_on_scales_kg));
  apply(derive_fittings(base.parameters, sheet.car.parameters, given));

  const VehicleParameters& car = sheet.car.parameters;
  const std::string name = fs::path(file).stem().string();
  const Comments comments(given, sheet.derived, base.parameters.name);
  SheetWriter out(fmt::format(
      "# {}: a car of its own. Change any number; `voltlap list car --vehicle {}` says what follows from them,\n"
      "# `voltlap list keys` which others there are. What is not here is {}'s.\n"
      "base = {}\nname = {}\n",
      name, file, base.parameters.name, quoted(name_from(data, "vehicles", request.from, "--from", file)),
      quoted(name)));
  for (const std::string& section : sections(given)) {
    out.section(section);
    if (section == "motor" && car.motor.model.empty()) {
      out.remark("model = \"emrax_228_hv\": a motor by its name (voltlap list motors); without it that of " +
                 base.parameters.name);
    }
    for (const std::string& key : keys_of(section, given, car)) {
      const ParameterRow* row = find_parameter(key);
      if (row == nullptr) {
        out.line(key, as_given[key], "yours");
      } else if (key == "battery.cell") {
        out.line(key, quoted(name_from(data, "cells", car.battery.cell, key, file)), comments.of(*row));
      } else if (key == "motor.model") {
        out.line(key, quoted(name_from(data, "motors", car.motor.model, key, file)), comments.of(*row));
      } else {
        out.line(key, value_text(*row, car), comments.of(*row));
      }
    }
  }
  sheet.numbers = out.numbers_;
  sheet.text = std::move(out.text_);
  VOLTLAP_DEMAND(sheet.numbers + 3 >= std::size(kSheet));
  return sheet;
}

}  // namespace voltlap::plant
