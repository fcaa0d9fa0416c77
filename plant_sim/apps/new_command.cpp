// SPDX-License-Identifier: Apache-2.0
#include "apps/new_command.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cstdio>
#include <filesystem>
#include <utility>

#include "apps/car_summary.hpp"
#include "apps/exit_code.hpp"
#include "apps/firmware_config.hpp"
#include "apps/flag_checks.hpp"
#include "core/errors.hpp"
#include "io/atomic_file.hpp"

namespace voltlap::plant {
namespace {

namespace fs = std::filesystem;

constexpr int kSeriesMost = 144, kParallelMost = 100;

/// 96x5, 96 x 5, 96s5p; nothing when it is neither.
std::optional<std::pair<int, int>> cells_of(const std::string& text) {
  int counts[2] = {0, 0};
  const char *at = text.data(), *end = text.data() + text.size();
  const auto read = [&](int& count, std::string_view stops) {
    const auto number = std::from_chars(at, end, count);
    if (number.ec != std::errc() || number.ptr == at) return false;
    at = number.ptr;
    while (at != end && stops.find(*at) != std::string_view::npos) ++at;
    return true;
  };
  if (!read(counts[0], " xXsS*") || at == text.data() + text.size()) return std::nullopt;
  if (!read(counts[1], "pP ") || at != end) return std::nullopt;
  const bool counted = counts[0] >= 1 && counts[0] <= kSeriesMost && counts[1] >= 1 && counts[1] <= kParallelMost;
  return counted ? std::optional(std::pair(counts[0], counts[1])) : std::nullopt;
}

CLI::Validator series_by_parallel() {
  return {[](std::string& text) {
            if (cells_of(text)) return std::string();
            return fmt::format("found {}; expected cells in series x in parallel, 1x1 to {}x{}, as 96x5 or 96s5p", text,
                               kSeriesMost, kParallelMost);
          },
          "SxP"};
}

/// The firmware's own check: what it refuses is named before anything is written.
void check_firmware(const LoadedVehicle& car) {
  static_cast<void>(table_rounding(car.parameters, bms_config(car.parameters, car.origin)));
  static_cast<void>(master_config(car.parameters, car.origin));
}

}  // namespace

NewCommand::NewCommand(CLI::App& app)
    : command_(app.add_subcommand("new", "A file for a car of your own, with what follows from its numbers")) {
  command_->require_subcommand(1);
  car_ = command_->add_subcommand("car", "Write NAME.toml: a car of your own, by the numbers that a team knows");
  car_->add_option("name", name_, "Of the car; its file is NAME.toml, a path is taken as it stands")->required();
  car_->add_option("--from", request_.from, "The car whose numbers stand for those that you do not know yet")
      ->capture_default_str();
  car_->add_option("--mass", request_.mass_on_scales_kg, "Car on the scales in kg, with its pack, without driver")
      ->type_name("KG")
      ->check(number_between(20.0, 3000.0));
  car_->add_option("--driver", driver_kg_, "Driver with equipment in kg")
      ->type_name("KG")
      ->check(number_between(0.0, 200.0));
  car_->add_option("--tyre-radius", tyre_radius_m_, "Rolling radius of the tyres under load in metres")
      ->type_name("M")
      ->check(number_between(0.05, 1.0));
  car_->add_option("--gear", gear_, "Final drive: motor turns per wheel turn")
      ->type_name("RATIO")
      ->check(number_between(0.5, 30.0));
  car_->add_option("--motor", motor_, "Name of a motor (voltlap list motors) or a TOML file")
      ->check(some_name("a motor"));
  car_->add_option("--cells", cells_, "Pack as cells in series x cells in parallel, as in 96x5")
      ->check(series_by_parallel());
  car_->add_option("--cell", cell_, "Name of a cell (voltlap list cells) or a TOML file")->check(some_name("a cell"));
  car_->add_option("--set", request_.settings, "Any other number, key=value, one or several (voltlap list keys)")
      ->type_name("KEY=VALUE")
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  car_->add_flag("--force", force_, "Write over a file of that name");
  car_->footer(
      "Example: voltlap new car ours --mass 245 --gear 3.9 --motor emrax_228_hv --cells 96x5 --cell molicel_p45b\n"
      "Then change what is wrong in ours.toml, and look: voltlap list car --vehicle ours.toml");
}

CarRequest NewCommand::request() const {
  CarRequest out = request_;
  const auto add = [&out](const char* key, const std::string& value) {
    out.settings.push_back(fmt::format("{}={}", key, value));
  };
  if (driver_kg_) add("vehicle.driver_mass_kg", fmt::format("{}", *driver_kg_));
  if (tyre_radius_m_) add("tyres.radius_m", fmt::format("{}", *tyre_radius_m_));
  if (gear_) add("powertrain.final_drive", fmt::format("{}", *gear_));
  if (!motor_.empty()) add("motor.model", motor_);
  if (!cell_.empty()) add("battery.cell", cell_);
  if (!cells_.empty()) {
    const auto [series, parallel] = *cells_of(cells_);
    add("battery.cells_in_series", fmt::format("{}", series));
    add("battery.cells_in_parallel", fmt::format("{}", parallel));
  }
  return out;
}

std::string NewCommand::file() const {
  const fs::path given(name_);
  const std::string stem = given.stem().string();
  if (stem.empty() || stem.find_first_of("\"\\\n\t") != std::string::npos || stem == "." || stem == "..") {
    throw InputError("new car", '"' + name_ + '"', "a name for the car and its file", "Write a word, as in ours");
  }
  return given.extension() == ".toml" ? name_ : name_ + ".toml";
}

int NewCommand::run(const DataFolder& data) {
  const std::string path = file();
  if (!force_ && fs::exists(path)) {
    throw InputError(path, "a file of that name", "a new one", "Take another name, or --force to write over it");
  }
  const CarSheet sheet = make_car_sheet(data, request(), path);
  const VehicleParameters& car = sheet.car.parameters;
  if (car.powertrain.kind != "electric") {
    throw InputError("--from " + request_.from, "a car without a motor", "an electric car", "Take another");
  }
  check_firmware(sheet.car);
  const CarSummary summary = summarise_car(car);
  AtomicFile out(path);
  out.write(sheet.text);
  out.commit();
  fmt::print("{}: {} numbers, each with its unit; the others are those of {}\n", path, sheet.numbers, request_.from);
  for (const DerivedNumber& number : sheet.derived) {
    fmt::print("  {} = {}  ({})\n", number.key, number.value, number.why);
  }
  fmt::print("what follows\n{}", car_text(car, summary));
  fmt::print("next: change what is wrong in {0}, then voltlap lap --vehicle {0}\n", path);
  return kExitOk;
}

}  // namespace voltlap::plant
