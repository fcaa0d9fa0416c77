// SPDX-License-Identifier: Apache-2.0
#include "apps/replay_pack.hpp"

#include <filesystem>

#include "core/model_file.hpp"

namespace voltlap::plant {
namespace {

/// The vehicle that a file is, or that a pack or a cell is put into, with settings of its own before the user's.
LoadedVehicle loaded(const DataFolder& data, const ModelFile& file, std::vector<std::string> own,
                     const std::vector<std::string>& settings) {
  std::vector<std::string> all;
  if (file.kind == ModelKind::kPack) all = pack_settings(file.path);
  if (file.kind == ModelKind::kCell) all = {"battery.cell=" + std::filesystem::absolute(file.path).string()};
  all.insert(all.end(), own.begin(), own.end());
  all.insert(all.end(), settings.begin(), settings.end());
  return load_vehicle(data, file.kind == ModelKind::kVehicle ? file.path : kPackBase, all);
}

}  // namespace

LoadedVehicle pack_of_own(const DataFolder& data, const std::string& pack, const std::vector<std::string>& settings) {
  return loaded(data, find_model_file(data, pack, "--pack"), {}, settings);
}

}  // namespace voltlap::plant
