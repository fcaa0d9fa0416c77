// SPDX-License-Identifier: Apache-2.0
// Vehicle, cell and motor files (TOML) and `--set key=value` become VehicleParameters.
// Precedence: --set, then the vehicle file, then the vehicle that it names as `base`, then the cell
// and motor files. Naming a motor (motor.model) drops what a base says of another.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "core/parameters.hpp"

namespace voltlap::plant {

/// Where the project's own vehicles, cells and tracks lie.
class DataFolder {
 public:
  explicit DataFolder(std::string root) : root_(std::move(root)) {}

  /// `kind` is vehicles, cells, motors, tracks, bench or maps. `name` is a name of that folder or a path; a relative
  /// path is looked up beside `beside` first when that is given. Throws InputError that begins with `place`, the flag
  /// or line that gave the name, and lists the names there are.
  [[nodiscard]] std::string find(const std::string& kind, const std::string& name, const std::string& place,
                                 const std::string& beside = {}) const;
  /// Names of a kind, sorted.
  [[nodiscard]] std::vector<std::string> names(const std::string& kind) const;
  [[nodiscard]] std::string path(const std::string& file) const { return root_ + "/" + file; }

 private:
  std::string root_;
};

struct LoadedVehicle {
  VehicleParameters parameters;
  /// For each key that was given: "file:line" or "--set key".
  std::map<std::string, std::string> origin;
  /// For each key that was given as lists within lists: how many there are on each level.
  std::map<std::string, std::vector<std::size_t>> shape;
};

/// A cell file alone, checked as it is within a vehicle; `place` is the flag that named it.
[[nodiscard]] CellParameters load_cell(const DataFolder& data, const std::string& name_or_path,
                                       const std::string& place);

/// Throws InputError for a missing file, bad TOML, an unknown key (with the nearest one), a wrong type, a value out of
/// range, a missing key, and for values that contradict each other.
[[nodiscard]] LoadedVehicle load_vehicle(const DataFolder& data, const std::string& name_or_path,
                                         const std::vector<std::string>& settings = {});

}  // namespace voltlap::plant
