// SPDX-License-Identifier: Apache-2.0
#include "apps/replay_by_role.hpp"

#include <optional>

#include "apps/firmware_config.hpp"
#include "apps/firmware_loop.hpp"
#include "apps/replay_pack.hpp"
#include "io/logs/role_map.hpp"
#include "replay/disagreements.hpp"
#include "replay/role_replay.hpp"

namespace voltlap::plant {
namespace {

constexpr double kVoltsPerCount = 1e-4;  // of the firmware's cell voltages

ReplayCar replayed_car(const VehicleParameters& car, const bms::Config& config) {
  ReplayCar out;
  out.cells = config.cells_in_series;
  out.thermistors = config.temperature_sensors;
  out.motor_constant_nm_per_a = 1e-6 * config.motor_constant_unm_per_a;
  out.full_brake_bar = car.brakes.full_pedal_pressure_bar;
  out.rest_current_a = 1e-3 * config.soc_start_current.raw();
  if (config.soc_method != bms::SocMethod::kNone) out.capacity_ah = 1e-3 * config.capacity_mah;
  out.cell_min_v = kVoltsPerCount * config.cell_voltage_min.raw();
  out.cell_max_v = kVoltsPerCount * config.cell_voltage_max.raw();
  return out;
}

}  // namespace

ReplayResult replay_by_role(const RoleReplayRequest& request, const DataFolder& data,
                            const std::function<void(const std::string&, double)>& progress) {
  request.finding.check_needed(!request.map.empty());
  progress("reading " + request.log, 0.0);
  std::optional<RoleMap> map = request.finding.find(request.log);
  if (!request.map.empty()) map = load_role_map(data.find("maps", request.map, "--map"));
  const DriveLog log = read_drive_log(request.log, map ? &*map : nullptr, data);
  const LoadedVehicle car = pack_of_log(data, request.pack, request.settings, log);
  const bms::Config config = bms_config(car.parameters, car.origin);
  const master::Config master = master_config(car.parameters, car.origin);
  FirmwareLoop firmware(config, master);
  progress("replaying", 0.5);
  ReplayResult out;
  out.log = request.log;
  out.map = log.map;
  out.pack = request.pack;
  replay_roles(log, replayed_car(car.parameters, config), pedal_sensors(master), !request.pack.empty(), firmware, out);
  out.disagreements = find_disagreements(out);
  return out;
}

}  // namespace voltlap::plant
