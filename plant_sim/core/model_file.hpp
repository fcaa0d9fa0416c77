// SPDX-License-Identifier: Apache-2.0
// A file that says what a battery is, of three kinds: a cell file, a pack file (a vehicle's [battery] alone), a
// vehicle.
#pragma once
#include <string>
#include <vector>

#include "core/parameter_file.hpp"

namespace voltlap::plant {

enum class ModelKind { kCell, kPack, kVehicle };

struct ModelFile {
  ModelKind kind = ModelKind::kCell;
  std::string path;
};

/// What a pack file does not say: its car, contactors, sensors.
inline constexpr const char* kPackBase = "vtm16e";

/// A vehicle or cell by name, or a path; `flag` is the one that gave it. Throws InputError for a file that is none of
/// the three.
[[nodiscard]] ModelFile find_model_file(const DataFolder& data, const std::string& name, const std::string& flag);

/// A pack file as settings on the car kPackBase; its cell may stand beside it.
[[nodiscard]] std::vector<std::string> pack_settings(const std::string& path);

}  // namespace voltlap::plant
