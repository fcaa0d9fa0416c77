// SPDX-License-Identifier: Apache-2.0
#include "apps/list_command.hpp"

#include <fmt/format.h>

#include <cstdio>

#include "apps/exit_code.hpp"
#include "apps/flag_checks.hpp"
#include "core/parameter_table.hpp"

namespace voltlap::plant {
namespace {

void print_keys(const VehicleParameters& car) {
  constexpr std::size_t kShown = 24;
  fmt::print("{:<44} {:<8} {:<18} {:<24} {}\n", "key", "unit", "range", "value of " + car.name, "meaning");
  for (const ParameterRow& row : parameter_rows()) {
    const std::string range = row.unit == "-" ? "" : fmt::format("{} .. {}", row.low, row.high);
    std::string value = value_text(row, car);
    if (value.size() > kShown) value = value.substr(0, kShown - 4) + " ...";
    fmt::print("{:<44} {:<8} {:<18} {:<24} {}\n", row.key, row.unit, range, value, row.description);
  }
  for (const CellVariationRow& row : cell_variation_rows()) {
    fmt::print("{:<44} {:<8} {:<18} {:<24} {}\n", fmt::format("battery.cells.<n>.{}", row.field), row.unit,
               fmt::format("{} .. {}", row.low, row.high), CellVariation{}.*row.value, row.description);
  }
}

}  // namespace

ListCommand::ListCommand(CLI::App& app)
    : command_(app.add_subcommand(
          "list", "Names of vehicles, tracks, cells, motors and bench plans; keys of --set with unit, range, value; "
                  "causes of explain")) {
  command_->add_option("what", what_, "vehicles, tracks, cells, motors, bench, keys or causes")
      ->required()
      ->check(one_of({"vehicles", "tracks", "cells", "motors", "bench", "keys", "causes"}));
  car_.add_vehicle(*command_);
  command_->footer("--vehicle and --set choose the car whose values `list keys` shows.");
}

int ListCommand::run(const DataFolder& data) {
  if (what_ == "keys") {
    print_keys(car_.load_car(data).parameters);
  } else {
    for (const std::string& name : data.names(what_)) fmt::print("{}\n", name);
  }
  return kExitOk;
}

}  // namespace voltlap::plant
