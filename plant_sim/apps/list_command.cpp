// SPDX-License-Identifier: Apache-2.0
#include "apps/list_command.hpp"

#include <fmt/format.h>

#include <cstdio>

#include "apps/car_summary.hpp"
#include "apps/exit_code.hpp"
#include "apps/firmware_config.hpp"
#include "apps/firmware_keys.hpp"
#include "apps/flag_checks.hpp"
#include "apps/part_lists.hpp"
#include "core/errors.hpp"
#include "core/parameter_table.hpp"

namespace voltlap::plant {
namespace {

/// What it is, what it follows while nobody gives it, and how finely the firmware counts it.
std::string meaning(const ParameterRow& row) {
  std::string out(row.description);
  if (!row.followed.words.empty()) out += fmt::format("; unless given {}", row.followed.words);
  const std::string step = firmware_step_text(row.key);
  return step.empty() ? out : out + fmt::format(" (in steps of {})", step);
}

void print_keys(const VehicleParameters& car) {
  constexpr std::size_t kShown = 24;
  fmt::print("{:<44} {:<8} {:<18} {:<24} {}\n", "key", "unit", "range", "value of " + car.name, "meaning");
  for (const ParameterRow& row : parameter_rows()) {
    const std::string range = row.unit == "-" ? "" : fmt::format("{} .. {}", row.low, row.high);
    std::string value = value_text(row, car);
    if (value.size() > kShown) value = value.substr(0, kShown - 4) + " ...";
    fmt::print("{:<44} {:<8} {:<18} {:<24} {}\n", row.key, row.unit, range, value, meaning(row));
  }
  for (const IndexedRow& row : indexed_rows()) {
    // Of the first one, as a car has it when nobody says anything.
    VehicleParameters first;
    first.battery.cells.resize(1);
    const auto value = row.get(first, 0);
    fmt::print("{:<44} {:<8} {:<18} {:<24} {}\n", fmt::format("{}.<n>.{}", row.prefix, row.field), row.unit,
               fmt::format("{} .. {}", row.low, row.high), value ? fmt::format("{}", *value) : "as for all",
               row.description);
  }
}

void print_car(const LoadedVehicle& car) {
  if (car.parameters.powertrain.kind != "electric") {
    throw InputError("powertrain.kind", '"' + car.parameters.powertrain.kind + '"', "\"electric\"",
                     "A car without a motor has nothing that follows");
  }
  static_cast<void>(bms_config(car.parameters, car.origin));
  static_cast<void>(master_config(car.parameters, car.origin));
  fmt::print("{}\n{}", car.parameters.name, car_text(car.parameters, summarise_car(car.parameters)));
}

}  // namespace

ListCommand::ListCommand(CLI::App& app)
    : command_(app.add_subcommand(
          "list", "Names of vehicles, tracks and bench plans; cells and motors with their numbers; keys of --set with "
                  "unit, range, value; what follows from a car's numbers; causes of explain")) {
  command_->add_option("what", what_, "vehicles, tracks, cells, motors, bench, keys, car or causes")
      ->required()
      ->check(one_of({"vehicles", "tracks", "cells", "motors", "bench", "keys", "car", "causes"}));
  car_.add_vehicle(*command_);
  command_->footer("--vehicle and --set choose the car of `list keys` and `list car`.");
}

int ListCommand::run(const DataFolder& data) {
  if (what_ == "keys") {
    print_keys(car_.load_car(data).parameters);
  } else if (what_ == "car") {
    print_car(car_.load_car(data));
  } else if (what_ == "motors") {
    fmt::print("{}", motor_list(data));
  } else if (what_ == "cells") {
    fmt::print("{}", cell_list(data));
  } else {
    for (const std::string& name : data.names(what_)) fmt::print("{}\n", name);
  }
  return kExitOk;
}

}  // namespace voltlap::plant
