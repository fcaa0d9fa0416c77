// SPDX-License-Identifier: Apache-2.0
// The flags that choose a car and a course, the same for every command that needs them.
#pragma once
#include <CLI/CLI.hpp>
#include <initializer_list>
#include <string>
#include <vector>

#include "core/parameter_file.hpp"
#include "race/track/lap_solver.hpp"
#include "race/track/track.hpp"

namespace voltlap::plant {

struct CarOptions {
  std::string vehicle = "vtm16e";
  std::string track = "michigan_2015";
  std::string lap_start = "flying";
  std::vector<std::string> settings;

  void add_vehicle(CLI::App& command);
  CLI::Option* add_track(CLI::App& command);
  CLI::Option* add_lap_start(CLI::App& command);

  [[nodiscard]] LoadedVehicle load_car(const DataFolder& data) const;
  /// Throws InputError for a --set of what a command draws or fixes by itself: it would change nothing.
  void refuse_own(const char* command, std::initializer_list<const char*> keys) const;
  [[nodiscard]] Track load_course(const DataFolder& data) const;
  [[nodiscard]] LapStart start() const { return lap_start == "standing" ? LapStart::kStanding : LapStart::kFlying; }
};

}  // namespace voltlap::plant
