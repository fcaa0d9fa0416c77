// SPDX-License-Identifier: Apache-2.0
#include "core/model_file.hpp"

#include <toml++/toml.h>

#include <algorithm>
#include <filesystem>
#include <sstream>

#include "core/errors.hpp"
#include "core/toml_text.hpp"

namespace voltlap::plant {
namespace {

namespace fs = std::filesystem;

std::string path_of(const DataFolder& data, const std::string& name, const std::string& flag) {
  for (const char* kind : {"vehicles", "cells"}) {
    const auto names = data.names(kind);
    if (std::find(names.begin(), names.end(), name) != names.end()) return data.find(kind, name, flag);
  }
  return data.find("vehicles", name, flag);
}

ModelKind kind_of(const std::string& path, const std::string& flag) {
  const toml::table table = parse_toml_file(path);
  if (table.contains("capacity_ah") || table.contains("breakpoints")) return ModelKind::kCell;
  if (table.contains("base") || table.contains("vehicle")) return ModelKind::kVehicle;
  if (table.contains("battery")) return ModelKind::kPack;
  throw InputError(shown_path(path), "neither capacity_ah, [battery] nor base",
                   "a cell file, a pack file ([battery] alone) or a vehicle file",
                   "Give one of the three as " + flag);
}

void flatten(const toml::table& table, const std::string& prefix, std::vector<std::string>& into) {
  for (const auto& [name, node] : table) {
    const std::string key = prefix + std::string(name.str());
    if (const toml::table* section = node.as_table()) {
      flatten(*section, key + ".", into);
      continue;
    }
    std::ostringstream text;
    node.visit([&](const auto& value) {
      if constexpr (toml::is_string<decltype(value)>) {
        text << toml::value<std::string>(value.get());
      } else {
        text << value;
      }
    });
    into.push_back(key + "=" + text.str());
  }
}

}  // namespace

ModelFile find_model_file(const DataFolder& data, const std::string& name, const std::string& flag) {
  const std::string path = path_of(data, name, flag);
  return {kind_of(path, flag), path};
}

std::vector<std::string> pack_settings(const std::string& path) {
  toml::table table = parse_toml_file(path);
  static_cast<void>(take_word(table, "name", shown_path(path)));
  if (toml::table* battery = table["battery"].as_table()) {
    const auto cell = (*battery)["cell"].value<std::string>();
    const fs::path beside = cell ? fs::path(path).parent_path() / *cell : fs::path();
    if (cell && fs::is_regular_file(beside)) battery->insert_or_assign("cell", beside.string());
  }
  std::vector<std::string> out;
  flatten(table, "", out);
  return out;
}

}  // namespace voltlap::plant
