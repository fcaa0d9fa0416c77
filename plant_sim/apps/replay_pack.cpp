// SPDX-License-Identifier: Apache-2.0
#include "apps/replay_pack.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iterator>

#include "can_dbc/car.hpp"
#include "core/errors.hpp"
#include "core/model_file.hpp"
#include "replay/role_inputs.hpp"

namespace voltlap::plant {
namespace {

constexpr std::size_t kMostCells = can::CellVoltages::kGroups * can::CellVoltages::kPerFrame;
constexpr std::size_t kMostThermistors = can::Temperatures::kGroups * can::Temperatures::kPerFrame;

/// Nothing that needs a model of the cells: no SOC, limits as wide as cells of any kind, a resistance so high that no
/// reading contradicts it.
constexpr const char* kWithoutModel[] = {
    "bms.soc_method=none",           "bms.resistance_ohm=0.05",      "bms.cell_voltage_trip_low_v=0.9",
    "bms.cell_voltage_min_v=1.0",    "bms.cell_voltage_max_v=4.45",  "bms.cell_voltage_trip_high_v=4.6",
    "bms.discharge_current_max_a=800", "bms.charge_current_max_a=800"};

std::vector<std::string> joined(std::vector<std::string> first, const std::vector<std::string>& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

/// The vehicle that a file is, or that a pack or a cell is put into, with settings of its own before the user's.
LoadedVehicle loaded(const DataFolder& data, const ModelFile& file, const std::vector<std::string>& own,
                     const std::vector<std::string>& settings) {
  std::vector<std::string> all;
  if (file.kind == ModelKind::kPack) all = pack_settings(file.path);
  if (file.kind == ModelKind::kCell) all = {"battery.cell=" + std::filesystem::absolute(file.path).string()};
  return load_vehicle(data, file.kind == ModelKind::kVehicle ? file.path : kPackBase,
                      joined(joined(all, own), settings));
}

}  // namespace

LoadedVehicle pack_of_own(const DataFolder& data, const std::string& pack, const std::vector<std::string>& settings) {
  return loaded(data, find_model_file(data, pack, "--pack"), {}, settings);
}

LoadedVehicle pack_of_log(const DataFolder& data, const std::string& pack, const std::vector<std::string>& settings,
                          const DriveLog& log) {
  const std::size_t recorded = recorded_cells(log);
  if (pack.empty() && recorded == 0) {
    throw InputError(log.path, "no cell voltage, and no pack that says how many cells share the pack's",
                     "cell_voltage_<n> in the map, or a pack file", "Give --pack");
  }
  std::vector<std::string> own;
  if (recorded > kMostCells) {
    throw InputError(log.path, fmt::format("{} cells", recorded),
                     fmt::format("at most the {} of can_dbc/car.dbc", kMostCells), "Replay the segments one by one");
  }
  ModelFile file{ModelKind::kPack, {}};
  if (!pack.empty()) file = find_model_file(data, pack, "--pack");
  if (pack.empty() || file.kind == ModelKind::kCell) {
    if (recorded > 0) own.push_back(fmt::format("battery.cells_in_series={}", recorded));
  }
  if (pack.empty()) own.insert(own.end(), std::begin(kWithoutModel), std::end(kWithoutModel));
  const LoadedVehicle first = pack.empty() ? load_vehicle(data, kPackBase, joined(own, settings))
                                           : loaded(data, file, own, settings);
  const auto cells = static_cast<std::size_t>(first.parameters.battery.cells_in_series);
  if (recorded > 0 && cells != recorded) {
    throw InputError(pack, fmt::format("{} cells in series", cells), fmt::format("the {} of {}", recorded, log.path),
                     "Correct battery.cells_in_series");
  }
  const std::size_t least = (cells + 4) / 5;  // EV.7.5: of 20 % of the cells
  own.push_back(fmt::format("sensors.temperature_count={}",
                            std::min(kMostThermistors, std::max(least, recorded_thermistors(log)))));
  return pack.empty() ? load_vehicle(data, kPackBase, joined(own, settings)) : loaded(data, file, own, settings);
}

}  // namespace voltlap::plant
