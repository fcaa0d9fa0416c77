// SPDX-License-Identifier: Apache-2.0
#include "discrepancy/extended_model.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

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
  for (const auto& [key, value] : parameter_values(from)) before[key] = value;
  std::map<std::string, std::string> out;
  for (const auto& [key, value] : parameter_values(to)) {
    const auto known = before.find(key);
    if (known == before.end() || known->second != value) out[key] = value;
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

}  // namespace

std::string extended_model_toml(const Model& model, const World& extended, const std::string& why) {
  auto changed = changes(model.world.car, extended.car);
  // What was brought to the log, and where the log began, is no part of the model.
  changed.erase("battery.cells_in_series");
  if (changed.empty()) return "";
  toml::table table;
  if (model.kind == ModelKind::kVehicle) {
    table.insert("base", std::filesystem::absolute(model.path).string());
  } else {
    table = parse_toml_file(model.path);
  }
  if (model.kind == ModelKind::kPack) {
    const auto cell = table["battery"]["cell"].value<std::string>();
    const auto beside = cell ? std::filesystem::path(model.path).parent_path() / *cell : std::filesystem::path();
    if (cell && std::filesystem::is_regular_file(beside)) {
      table["battery"].as_table()->insert_or_assign("cell", std::filesystem::absolute(beside).string());
    }
  }
  for (const auto& [key, value] : changed) {
    if (model.kind == ModelKind::kCell && !key.starts_with("cell.")) continue;
    put(table, model.kind == ModelKind::kCell ? key.substr(5) : key, value);
  }
  std::ostringstream text;
  text << "# " << std::filesystem::path(model.path).filename().string() << " as extended by voltlap explain.\n# " << why
       << "\n" << table << "\n";
  return text.str();
}

}  // namespace voltlap::plant
