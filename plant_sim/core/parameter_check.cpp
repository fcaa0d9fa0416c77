// SPDX-License-Identifier: Apache-2.0
#include "core/parameter_check.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <tuple>
#include <utility>

#include "core/demand.hpp"
#include "core/errors.hpp"

namespace voltlap::plant {
namespace {

using Values = std::vector<double>;

class Check {
 public:
  explicit Check(const LoadedVehicle& vehicle) : origin_(vehicle.origin), shape_(vehicle.shape) {}

  void increasing(const std::string& key, const Values& values, bool strictly = true) const {
    for (std::size_t i = 1; i < values.size(); ++i) {
      if (strictly ? values[i] > values[i - 1] : values[i] >= values[i - 1]) continue;
      throw InputError(place(key), fmt::format("{} after {}", values[i], values[i - 1]),
                       strictly ? "each value greater than the one before" : "no value less than the one before",
                       "Put the points in order");
    }
  }

  void length(const std::string& key, const Values& values, std::size_t expected, const std::string& because) const {
    if (values.size() == expected) return;
    throw InputError(place(key), fmt::format("{} values", values.size()),
                     fmt::format("{}, {}", expected, because), "Give one value for every point");
  }

  /// A table of lists within lists must be as deep and as long on each level; a flat list has no levels to compare.
  void shape(const std::string& key, const std::vector<std::size_t>& expected, const std::string& because) const {
    const auto given = shape_.find(key);
    if (given == shape_.end() || given->second == expected) return;
    throw InputError(place(key), fmt::format("a table of {}", fmt::join(given->second, " x ")),
                     fmt::format("{}, {}", fmt::join(expected, " x "), because), "Arrange the values so");
  }

  /// Only a cell's tables may be lists within lists.
  void flat_but_tables() const {
    for (const auto& [key, levels] : shape_) {
      that(key.ends_with(".table"), key, fmt::format("a table of {}", fmt::join(levels, " x ")), "a list of numbers",
           "Remove the inner brackets");
    }
  }

  void that(bool ok, const std::string& key, const std::string& found, const std::string& expected,
            const std::string& what_to_do) const {
    if (!ok) throw InputError(place(key), found, expected, what_to_do);
  }

 private:
  [[nodiscard]] std::string place(const std::string& key) const {
    const auto known = origin_.find(key);
    if (known == origin_.end()) return in_file_of_its_like(key);
    return known->second.ends_with(key) ? known->second : fmt::format("{}, {}", known->second, key);
  }
  /// A key that stands nowhere, with the file in which the others of its section do: "cell.toml, cell.r1.table".
  [[nodiscard]] std::string in_file_of_its_like(const std::string& key) const {
    const std::string section = key.substr(0, key.find('.') + 1);
    const auto like = origin_.lower_bound(section);
    if (section.empty() || like == origin_.end() || !like->first.starts_with(section)) return key;
    const std::string& place = like->second;
    const std::size_t line = place.rfind(':');
    const bool is_file =
        line != std::string::npos && place.find_first_not_of("0123456789", line + 1) == std::string::npos;
    return is_file ? fmt::format("{}, {}", place.substr(0, line), key) : key;
  }
  const std::map<std::string, std::string>& origin_;
  const std::map<std::string, std::vector<std::size_t>>& shape_;
};

void check_ocv(const Check& check, const CellParameters& cell) {
  check.that(cell.ocv_polynomial_v.empty() != cell.ocv_soc.empty(),
             cell.ocv_polynomial_v.empty() ? "cell.ocv.soc" : "cell.ocv.polynomial_v",
             cell.ocv_soc.empty() ? "no open-circuit voltage" : "two open-circuit voltages",
             "either ocv.polynomial_v, or ocv.soc with ocv.voltage_v", "Keep one form in the [ocv] section");
  if (!cell.ocv_soc.empty()) {
    check.increasing("cell.ocv.soc", cell.ocv_soc);
    check.length("cell.ocv.voltage_v", cell.ocv_v, cell.ocv_soc.size(), "as many as ocv.soc");
    check.increasing("cell.ocv.voltage_v", cell.ocv_v, false);
  }
}

bool is_given(const CellParameterMap& map) {
  return !map.value.empty() || !map.table.empty() || map.per_kelvin != 0.0 || map.per_ampere != 0.0 ||
         map.activation_energy_j_per_mol != 0.0;
}

/// `name`: the section, such as r1.
void check_map(const Check& check, const CellParameters& cell, const std::string& name, const CellParameterMap& map) {
  const std::string section = "cell." + name;
  check.that(map.value.empty() != map.table.empty(), section + (map.value.empty() ? ".table" : ".value"),
             map.table.empty() ? "no values" : "both value and table",
             fmt::format("either {}.value or {}.table", name, name), "Keep one of the two");
  const std::vector<std::size_t> shape = {cell.soc_breakpoints.size(), cell.temperature_breakpoints_c.size(),
                                          cell.current_breakpoints_a.size()};
  if (map.table.empty()) {
    check.length(section + ".value", map.value, shape[0], "one for each point of breakpoints.soc");
  } else {
    check.length(section + ".table", map.table, shape[0] * shape[1] * shape[2],
                 "SOC points times temperatures times currents");
    check.shape(section + ".table", shape, "SOC points x temperatures x currents");
  }
}

/// One branch or more, numbered without a gap, each of a resistance and a time constant.
void check_branches(const Check& check, const CellParameters& cell) {
  std::size_t missing = 0;
  for (std::size_t k = 1; k <= cell.branches.size(); ++k) {
    const CellBranch& branch = cell.branches[k - 1];
    const bool has_r = is_given(branch.r_ohm), has_tau = is_given(branch.tau_s);
    if (k > 1 && !has_r && !has_tau) {
      if (missing == 0) missing = k;
      continue;
    }
    const std::string section = fmt::format("{}{}", has_r ? "r" : "tau", k);
    const CellParameterMap& first = has_r ? branch.r_ohm : branch.tau_s;
    check.that(missing == 0, fmt::format("cell.{}.{}", section, first.table.empty() ? "value" : "table"),
               fmt::format("RC branch {} without branch {}", k, missing),
               "branches that are numbered from 1 on without a gap",
               fmt::format("Add [r{0}] and [tau{0}], or rename the sections", missing));
    check_map(check, cell, fmt::format("r{}", k), branch.r_ohm);
    check_map(check, cell, fmt::format("tau{}", k), branch.tau_s);
  }
}

void check_maps(const Check& check, const CellParameters& cell) {
  check_map(check, cell, "r0", cell.r0_ohm);
  check_branches(check, cell);
  if (!cell.ocv_table_v.empty()) {
    const std::vector<std::size_t> shape = {cell.soc_breakpoints.size(), cell.temperature_breakpoints_c.size(),
                                            cell.current_breakpoints_a.size()};
    check.length("cell.ocv.table", cell.ocv_table_v, shape[0] * shape[1] * shape[2],
                 "SOC points times temperatures times currents");
    check.shape("cell.ocv.table", shape, "SOC points x temperatures x currents");
  }
}

void check_cell(const Check& check, const CellParameters& cell) {
  check.increasing("cell.breakpoints.soc", cell.soc_breakpoints);
  check.increasing("cell.breakpoints.temperature_c", cell.temperature_breakpoints_c);
  check.increasing("cell.breakpoints.current_a", cell.current_breakpoints_a);
  check.that(cell.soc_breakpoints.size() >= 2, "cell.breakpoints.soc",
             fmt::format("{} points", cell.soc_breakpoints.size()), "at least 2", "Add points");
  check.that(cell.voltage_min_v < cell.voltage_max_v, "cell.voltage_min_v", fmt::format("{} V", cell.voltage_min_v),
             fmt::format("less than voltage_max_v, {} V", cell.voltage_max_v), "Change one of the two");
  check_ocv(check, cell);
  check_maps(check, cell);
}

void check_instrument(const Check& check, const std::string& prefix, const std::string& suffix,
                      const ReadingErrors& errors) {
  const double periods = errors.delay_s / kInstrumentPeriod_s;
  check.that(std::abs(periods - std::round(periods)) < 1e-6, prefix + ".delay_s", fmt::format("{:g} s", errors.delay_s),
             fmt::format("a multiple of {:g} s, the period of the sensors", kInstrumentPeriod_s), "Round the value");
  check.that(errors.min < errors.max, prefix + ".min_" + suffix, fmt::format("{:g}", errors.min),
             fmt::format("less than {}.max_{}, {:g}", prefix, suffix, errors.max), "Change one of the two");
}

void check_instruments(const Check& check, const SensorSection& s) {
  const std::tuple<const char*, const char*, const ReadingErrors*> single[] = {
      {"cells", "v", &s.all_cells}, {"thermistors", "c", &s.all_thermistors}, {"pack_current", "a", &s.pack_current},
      {"pack_voltage", "v", &s.pack_voltage}, {"dc_link_voltage", "v", &s.dc_link_voltage},
      {"phase_current", "a", &s.phase_current}, {"motor_speed", "rpm", &s.motor_speed},
      {"motor_temperature", "c", &s.motor_temperature}, {"inverter_temperature", "c", &s.inverter_temperature},
      {"wheel_front_left", "mps", &s.wheel_front_left}, {"wheel_front_right", "mps", &s.wheel_front_right},
      {"wheel_rear_left", "mps", &s.wheel_rear_left}, {"wheel_rear_right", "mps", &s.wheel_rear_right},
      {"apps1", "v", &s.apps1}, {"apps2", "v", &s.apps2}, {"brake_front", "bar", &s.brake_front},
      {"brake_rear", "bar", &s.brake_rear}};
  for (const auto& [name, suffix, errors] : single)
    check_instrument(check, std::string("sensors.") + name, suffix, *errors);
  for (std::size_t n = 0; n < s.cells.size(); ++n)
    check_instrument(check, fmt::format("sensors.cells.{}", n + 1), "v", s.cells[n].over(s.all_cells));
  for (std::size_t n = 0; n < s.thermistors.size(); ++n)
    check_instrument(check, fmt::format("sensors.thermistors.{}", n + 1), "c",
                     s.thermistors[n].over(s.all_thermistors));
}

/// Four inverters are those of an AMK kit, and no other protocol addresses four.
void check_motors(const Check& check, const VehicleParameters& p) {
  const std::string& protocol = p.inverter.protocol;
  const int motors = p.powertrain.motors;
  const bool amk = protocol == "amk";
  check.that(amk || protocol == "phase_current" || protocol == "pm100", "inverter.protocol", '"' + protocol + '"',
             "\"phase_current\", \"pm100\" or \"amk\"", "Choose one of the three");
  check.that(motors == 1 || motors == 4, "powertrain.motors", fmt::format("{} motors", motors),
             "1, on the rear axle, or 4, one a wheel", "Choose one of the two");
  check.that(!amk || motors == 4, "inverter.protocol", "\"amk\" with one motor",
             "four motors: an AMK kit has an inverter a wheel",
             "Set powertrain.motors = 4 too, with motor.*, inverter.* and powertrain.final_drive of each, or take the "
             "vehicle amk_4wd");
  check.that(amk || motors == 1, "powertrain.motors", fmt::format("4 motors with inverter.protocol \"{}\"", protocol),
             "\"amk\": the other protocols address one inverter",
             "Set inverter.protocol = \"amk\" too, or one motor");
}

}  // namespace

void check_cell_consistency(const LoadedVehicle& holder) {
  const Check check(holder);
  check.flat_but_tables();
  check_cell(check, holder.parameters.cell);
}

void check_consistency(const LoadedVehicle& vehicle) {
  const Check check(vehicle);
  const VehicleParameters& p = vehicle.parameters;
  check.flat_but_tables();
  check_instruments(check, p.sensors);
  check_cell(check, p.cell);
  check_motors(check, p);
  check.that(p.powertrain.kind == "electric" || p.powertrain.kind == "none", "powertrain.kind",
             '"' + p.powertrain.kind + '"', "\"electric\" or \"none\"", "Choose one of the two");
  const bool weighed = p.vehicle.mass_kg > 0.0, without_pack = p.vehicle.mass_without_pack_kg > 0.0;
  check.that(weighed != without_pack, without_pack ? "vehicle.mass_without_pack_kg" : "vehicle.mass_kg",
             weighed ? "two masses" : "no mass",
             "either vehicle.mass_kg, as weighed and the same with any pack, or vehicle.mass_without_pack_kg",
             "Keep one of the two lines");
  for (std::size_t i = 0; i < p.battery.cells.size(); ++i) {
    const double soc = p.battery.initial_soc + p.battery.cells[i].initial_soc_offset;
    check.that(within(soc, 0.0, 1.0), fmt::format("battery.cells.{}.initial_soc_offset", i + 1),
               fmt::format("a cell that starts at {:.1f} % charge", 100.0 * soc),
               "0 to 100 %, with battery.initial_soc",
               "Change the offset or battery.initial_soc: no table says what a cell does beyond");
  }
  check.increasing("motor.curve_speed_rpm", p.motor.curve_speed_rpm);
  check.that(p.motor.curve_speed_rpm.size() >= 2, "motor.curve_speed_rpm",
             fmt::format("{} points", p.motor.curve_speed_rpm.size()), "at least 2", "Add points to the torque curve");
  check.length("motor.curve_torque_nm", p.motor.curve_torque_nm, p.motor.curve_speed_rpm.size(),
               "as many as motor.curve_speed_rpm");
}

}  // namespace voltlap::plant
