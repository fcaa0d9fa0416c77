// SPDX-License-Identifier: Apache-2.0
#include "apps/car_options.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "apps/flag_checks.hpp"
#include "car/powertrain/motor_voltage.hpp"
#include "core/errors.hpp"

namespace voltlap::plant {

void CarOptions::add_vehicle(CLI::App& command) {
  command.add_option("--vehicle", vehicle, "Name of a vehicle (voltlap list vehicles) or a TOML file")
      ->capture_default_str();
  command
      .add_option("--set", settings,
                  "Change parameters, key=value, one or several; may be given again (voltlap list keys)")
      ->type_name("KEY=VALUE")
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
}

CLI::Option* CarOptions::add_track(CLI::App& command) {
  return command.add_option("--track", track, "Name of a track (voltlap list tracks) or a CSV file")
      ->capture_default_str();
}

CLI::Option* CarOptions::add_lap_start(CLI::App& command) {
  return command
      .add_option(
          "--lap-start", lap_start,
          "flying: one periodic lap, the run ends when the laps are driven; standing: a lap from rest, repeated "
          "in time as in the reference study")
      ->check(one_of({"flying", "standing"}))
      ->capture_default_str();
}

LoadedVehicle CarOptions::load_car(const DataFolder& data) const {
  LoadedVehicle car = load_vehicle(data, vehicle, settings);
  check_motor_voltage(car);
  return car;
}

void CarOptions::refuse_own(const char* command, std::initializer_list<const char*> keys) const {
  for (const std::string& setting : settings) {
    const std::size_t equals = setting.find('=');
    if (equals == std::string::npos) continue;  // its own error
    const std::string key = setting.substr(0, equals);
    if (std::find(keys.begin(), keys.end(), key) == keys.end()) continue;
    throw InputError("--set " + key, setting.substr(equals + 1),
                     fmt::format("a key that {} does not set by itself: this one would change nothing", command),
                     "Leave it out");
  }
}

Track CarOptions::load_course(const DataFolder& data) const {
  return load_track(data.find("tracks", track, "--track"));
}

}  // namespace voltlap::plant
