// SPDX-License-Identifier: Apache-2.0
#include "core/parameter_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <optional>

#include "core/demand.hpp"
#include "core/errors.hpp"
#include "core/parameter_check.hpp"
#include "core/parameter_table.hpp"
#include "core/toml_text.hpp"

namespace voltlap::plant {
namespace {

namespace fs = std::filesystem;

enum class Rank { kPartFile, kVehicle, kSetting };  // a part: a cell or a motor

/// One `key = value`, from wherever it came.
struct Assignment {
  std::shared_ptr<toml::node> value;
  std::string place;  ///< "file:line" or "--set key"
  Rank rank;
};
using Assignments = std::map<std::string, Assignment>;

constexpr const char* kPackBase = "vtm16e";  // the car around a pack file
constexpr std::string_view kMotorPrefix = "motor.", kMotorModel = "motor.model";

std::string folder_of(const std::string& path) { return fs::path(path).parent_path().string(); }

/// Where a value came from and which key it is for; a --set names its key already.
std::string place_of(const Assignment& assignment, std::string_view key) {
  return assignment.rank == Rank::kSetting ? assignment.place : fmt::format("{}, {}", assignment.place, key);
}

struct IndexedKey {
  std::size_t index;  ///< from 0
  const IndexedRow* row;
};

/// <prefix>.<n>.<field>
std::optional<IndexedKey> parse_indexed_key(std::string_view key) {
  constexpr std::size_t kDigitsMax = 3;
  for (const IndexedRow& row : indexed_rows()) {
    if (!key.starts_with(row.prefix) || !key.ends_with(row.field)) continue;
    if (key.size() < row.prefix.size() + row.field.size() + 3) continue;
    const std::string_view middle = key.substr(row.prefix.size(), key.size() - row.prefix.size() - row.field.size());
    if (middle.front() != '.' || middle.back() != '.') continue;
    const std::string_view digits = middle.substr(1, middle.size() - 2);
    std::size_t number = 0;
    const auto read = std::from_chars(digits.data(), digits.data() + digits.size(), number);
    if (read.ec != std::errc() || read.ptr != digits.data() + digits.size()) continue;
    if (digits.size() <= kDigitsMax && number >= 1) return IndexedKey{number - 1, &row};
  }
  return std::nullopt;
}

/// Keys that earlier versions had, and what stands in their place.
constexpr std::pair<std::string_view, std::string_view> kRetired[] = {
    {"tyres.friction",
     "The lap and the road have one tyre now: tyres.pacejka_d is its grip, tyres.lateral_grip the ratio across"},
};

/// Two ways to say one thing: what is said later, in another file or setting, holds.
constexpr std::pair<std::string_view, std::string_view> kAlternatives[] = {
    {"vehicle.mass_kg", "vehicle.mass_without_pack_kg"},
};

/// What follows another key unless it is given beside it: who changes the first means both.
constexpr std::pair<std::string_view, std::string_view> kFollowers[] = {
    {"tyres.radius_m", "tyres.lap_radius_m"},
};

std::string file_of(const Assignment& assignment) { return assignment.place.substr(0, assignment.place.rfind(':')); }

void drop_alternative(Assignments& into, const std::string& key, const Assignment& assignment) {
  for (const auto& [one, other] : kAlternatives) {
    if (key != one && key != other) continue;
    const auto rival = into.find(std::string(key == one ? other : one));
    if (rival == into.end()) continue;
    if (rival->second.rank != assignment.rank || file_of(rival->second) != file_of(assignment)) into.erase(rival);
  }
}

void drop_follower(Assignments& into, const std::string& key, const Assignment& assignment) {
  for (const auto& [leader, follower] : kFollowers) {
    if (key != leader) continue;
    const auto given = into.find(std::string(follower));
    if (given == into.end()) continue;
    const Assignment& other = given->second;
    const bool beside = other.rank == assignment.rank &&
                        (assignment.rank == Rank::kSetting || file_of(other) == file_of(assignment));
    if (!beside) into.erase(given);
  }
}

/// Who names a motor means all of it: what the car's base says of another motor does not hold any more.
void drop_motor(Assignments& into, const Assignment& model) {
  std::erase_if(into, [&](const auto& entry) {
    const Assignment& other = entry.second;
    return entry.first.starts_with(kMotorPrefix) &&
           (other.rank != model.rank || (model.rank == Rank::kVehicle && file_of(other) != file_of(model)));
  });
}

void put(Assignments& into, const std::string& key, Assignment assignment) {
  for (const auto& [retired, advice] : kRetired) {
    if (key == retired) throw InputError(assignment.place, fmt::format("the key \"{}\"", key), "a key of today",
                                         std::string(advice));
  }
  if (find_parameter(key) == nullptr && !parse_indexed_key(key)) {
    throw InputError(fmt::format(
        "{}: found the unknown key \"{}\"; expected a key that `voltlap list keys` shows. Did you mean \"{}\"?",
        assignment.place, key, nearest_key(key)));
  }
  drop_alternative(into, key, assignment);
  drop_follower(into, key, assignment);
  if (key == kMotorModel) drop_motor(into, assignment);
  into.insert_or_assign(key, std::move(assignment));
}

void flatten(const toml::table& table, const std::string& prefix, const std::string& file, Rank rank,
             Assignments& into) {
  for (const auto& [name, node] : table) {
    const std::string key = prefix + std::string(name.str());
    if (const toml::table* section = node.as_table()) {
      flatten(*section, key + ".", file, rank, into);
    } else {
      put(into, key, {copy_of(node), fmt::format("{}:{}", file, node.source().begin.line), rank});
    }
  }
}

/// A pack file is a vehicle's [battery] alone, perhaps with what it says of its cell, contactors or surroundings.
bool is_pack_file(const toml::table& table) {
  constexpr const char* kCar[] = {"vehicle", "tyres", "powertrain", "motor"};
  return table.contains("battery") &&
         std::none_of(std::begin(kCar), std::end(kCar), [&](const char* section) { return table.contains(section); });
}

/// `chain`: the files that are built on this one, by `base`, up to the car that was asked for.
void read_vehicle(const DataFolder& data, const std::string& path, std::vector<std::string> chain, Assignments& into,
                  std::string& name) {
  toml::table table = parse_toml_file(path);
  const toml::node* base_line = table.get("base");
  const std::string place =
      base_line == nullptr ? "" : fmt::format("{}:{}, base", shown_path(path), base_line->source().begin.line);
  std::string base = take_word(table, "base", shown_path(path));
  if (base.empty() && is_pack_file(table)) base = kPackBase;
  chain.push_back(fs::weakly_canonical(path).string());
  if (!base.empty()) {
    const std::string base_path = data.find("vehicles", base, place, folder_of(path));
    if (std::find(chain.begin(), chain.end(), fs::weakly_canonical(base_path).string()) != chain.end()) {
      throw InputError(place, fmt::format("a circle: {} is built on this file", shown_path(base_path)),
                       "a chain of vehicles that ends in one without base", "Remove one of the base lines");
    }
    read_vehicle(data, base_path, chain, into, name);
  }
  name = take_word(table, "name", shown_path(path));
  if (name.empty()) name = fs::path(path).stem().string();
  flatten(table, "", shown_path(path), Rank::kVehicle, into);
}

void read_setting(const std::string& text, Assignments& into) {
  Setting setting = parse_setting(text);
  put(into, setting.key, {std::move(setting.value), "--set " + setting.key, Rank::kSetting});
}

/// The file of a part, `prefix` its section.
void read_part_file(const std::string& path, const std::string& prefix, Assignments& into) {
  Assignments part;
  flatten(parse_toml_file(path), prefix, shown_path(path), Rank::kPartFile, part);
  into.merge(part);  // keeps what a vehicle file or --set gave already
}

/// The file of the part that `key` names; empty when none is named.
std::string find_part(const DataFolder& data, const char* kind, const std::string& key, const Assignments& given,
                      const std::string& vehicle_path) {
  const auto named = given.find(key);
  if (named == given.end() || !named->second.value->is_string()) return {};
  const std::string name = *named->second.value->value<std::string>();
  if (name.empty() && key == kMotorModel) return {};
  return data.find(kind, name, place_of(named->second, key), folder_of(vehicle_path));
}

class Store {
 public:
  Store(LoadedVehicle& into, const ParameterRow& row, const Assignment& from)
      : into_(into.parameters), shape_(into.shape), row_(row), node_(*from.value), place_(place_of(from, row.key)) {}

  void operator()(double& (*access)(VehicleParameters&)) const { access(into_) = number_in_range(node_); }
  void operator()(std::optional<double>& (*access)(VehicleParameters&)) const {
    access(into_) = number_in_range(node_);
  }
  void operator()(int& (*access)(VehicleParameters&)) const {
    if (!node_.is_integer()) wrong(node_);
    access(into_) = static_cast<int>(number_in_range(node_));
  }
  void operator()(bool& (*access)(VehicleParameters&)) const {
    if (!node_.is_boolean()) wrong(node_);
    access(into_) = *node_.value<bool>();
  }
  void operator()(std::string& (*access)(VehicleParameters&)) const {
    if (!node_.is_string()) wrong(node_);
    access(into_) = *node_.value<std::string>();
  }
  void operator()(std::vector<double>& (*access)(VehicleParameters&)) const {
    if (!node_.is_array()) wrong(node_);
    std::vector<double>& list = access(into_);
    list.clear();
    std::vector<std::size_t> shape;
    append(*node_.as_array(), 0, shape, list);
    if (shape.size() > 1) shape_[std::string(row_.key)] = shape;
  }

 private:
  /// Lists within lists, the innermost fastest; those of a level must be equally long.
  void append(const toml::array& array, std::size_t level, std::vector<std::size_t>& shape,
              std::vector<double>& list) const {
    VOLTLAP_DEMAND(level <= shape.size());
    if (level == shape.size() && list.empty()) shape.push_back(array.size());
    if (level >= shape.size()) ragged(array.size(), 1);
    if (shape[level] != array.size()) ragged(array.size(), shape[level]);
    for (const toml::node& element : array) {
      if (const toml::array* inner = element.as_array()) {
        append(*inner, level + 1, shape, list);
      } else {
        if (level + 1 != shape.size()) ragged(1, shape[level + 1]);
        list.push_back(number_in_range(element));
      }
    }
  }
  [[noreturn]] void ragged(std::size_t found, std::size_t expected) const {
    throw InputError(place_, fmt::format("a list of {} beside one of {}", found, expected),
                     "lists of one length on each level", "Complete the table");
  }
  [[nodiscard]] double number_in_range(const toml::node& node) const {
    const std::optional<double> number = number_of(node);
    if (!number || !(*number >= row_.low && *number <= row_.high)) wrong(node);
    return *number;
  }
  [[noreturn]] void wrong(const toml::node& node) const {
    throw InputError(place_, found_text(node), expectation(row_), "Correct the value");
  }

  VehicleParameters& into_;
  std::map<std::string, std::vector<std::size_t>>& shape_;
  const ParameterRow& row_;
  const toml::node& node_;
  std::string place_;
};

void store_indexed(const Assignments& given, VehicleParameters& into) {
  for (const auto& [key, assignment] : given) {
    const auto parsed = parse_indexed_key(key);
    if (!parsed) continue;
    const std::string place = place_of(assignment, key);
    const auto& row = *parsed->row;
    const std::size_t count = indexed_count(row.prefix, into);
    if (parsed->index >= count) {
      const bool cell = row.prefix.ends_with("cells");
      throw InputError(place, fmt::format("{} {}", cell ? "cell" : "thermistor", parsed->index + 1),
                       fmt::format("a {} from 1 to {}", cell ? "cell" : "thermistor", count),
                       cell ? "Name a cell that the pack has" : "Name a thermistor that the pack has");
    }
    const auto number = number_of(*assignment.value);
    if (!number || !(*number >= row.low && *number <= row.high)) {
      throw InputError(place, found_text(*assignment.value), fmt::format("a number from {} to {}", row.low, row.high),
                       "Correct the value");
    }
    row.put(into, parsed->index, *number);
  }
}

/// battery.<field> and cell.<field> are one number: the one of higher rank holds, on a tie the battery's.
void unify(Assignments& given, const std::string& field, double& battery, double& cell) {
  const auto of_battery = given.find("battery." + field), of_cell = given.find("cell." + field);
  const bool battery_holds =
      of_battery != given.end() && (of_cell == given.end() || of_battery->second.rank >= of_cell->second.rank);
  (battery_holds ? cell : battery) = battery_holds ? battery : cell;
  if (battery_holds) {
    given.insert_or_assign("cell." + field, of_battery->second);
  } else if (of_cell != given.end()) {
    given.insert_or_assign("battery." + field, of_cell->second);
  }
}

void require_all(const Assignments& given, const std::string& vehicle, const std::string& cell) {
  for (const ParameterRow& row : parameter_rows()) {
    if (row.presence != Presence::kRequired || given.contains(std::string(row.key))) continue;
    throw InputError(row.key.starts_with("cell.") ? cell : vehicle, fmt::format("no {}", row.key), expectation(row),
                     fmt::format("Add a line for it ({}), or start from another file with base = \"vtm16e\"",
                                 row.description));
  }
}

}  // namespace

CellParameters load_cell(const DataFolder& data, const std::string& name_or_path, const std::string& place) {
  Assignments given;
  const std::string path = data.find("cells", name_or_path, place);
  read_part_file(path, "cell.", given);
  LoadedVehicle holder;
  for (const ParameterRow& row : parameter_rows()) {
    if (!row.key.starts_with("cell.")) continue;
    const auto assignment = given.find(std::string(row.key));
    if (assignment != given.end()) {
      std::visit(Store(holder, row, assignment->second), row.access);
    } else if (row.presence == Presence::kRequired) {
      throw InputError(shown_path(path), fmt::format("no {}", row.key.substr(5)), expectation(row),
                       fmt::format("Add a line for it ({})", row.description));
    }
  }
  CellParameters& cell = holder.parameters.cell;
  if (cell.name.empty()) cell.name = fs::path(path).stem().string();
  for (const auto& [key, assignment] : given) holder.origin.emplace(key, assignment.place);
  check_cell_consistency(holder);
  VOLTLAP_DEMAND(!cell.name.empty() && !holder.origin.empty());
  VOLTLAP_DEMAND(increasing(cell.soc_breakpoints));
  return cell;
}

LoadedVehicle load_vehicle(const DataFolder& data, const std::string& name_or_path,
                           const std::vector<std::string>& settings) {
  LoadedVehicle out;
  Assignments given;
  const std::string path = data.find("vehicles", name_or_path, "--vehicle");
  read_vehicle(data, path, {}, given, out.parameters.name);
  for (const std::string& setting : settings) read_setting(setting, given);

  std::string cell_path = find_part(data, "cells", "battery.cell", given, path);
  if (cell_path.empty()) {
    cell_path = "the cell file";
  } else {
    read_part_file(cell_path, "cell.", given);
  }
  const std::string motor_path = find_part(data, "motors", std::string(kMotorModel), given, path);
  if (!motor_path.empty()) read_part_file(motor_path, std::string(kMotorPrefix), given);
  require_all(given, shown_path(path), shown_path(cell_path));
  for (const ParameterRow& row : parameter_rows()) {
    const auto assignment = given.find(std::string(row.key));
    if (assignment != given.end()) std::visit(Store(out, row, assignment->second), row.access);
  }
  store_indexed(given, out.parameters);
  VehicleParameters& p = out.parameters;
  unify(given, "capacity_ah", p.battery.capacity_ah, p.cell.capacity_ah);
  unify(given, "convection_w_per_m2_k", p.battery.convection_w_per_m2_k, p.cell.convection_w_per_m2_k);
  if (p.cell.name.empty()) p.cell.name = fs::path(cell_path).stem().string();
  if (p.tyres.lap_radius_m == 0.0) p.tyres.lap_radius_m = p.tyres.radius_m;

  for (const auto& [key, assignment] : given) out.origin.emplace(key, assignment.place);
  check_consistency(out);
  VOLTLAP_DEMAND(p.battery.capacity_ah == p.cell.capacity_ah);
  VOLTLAP_DEMAND(p.battery.cells.size() <= static_cast<std::size_t>(p.battery.cells_in_series));
  return out;
}

}  // namespace voltlap::plant
