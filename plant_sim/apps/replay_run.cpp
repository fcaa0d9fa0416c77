// SPDX-License-Identifier: Apache-2.0
#include "apps/replay_run.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "apps/firmware_config.hpp"
#include "apps/firmware_loop.hpp"
#include "apps/progress_line.hpp"
#include "apps/replay_pack.hpp"
#include "bms/estimate/soc_ekf.hpp"
#include "io/logs/role_map.hpp"
#include "replay/disagreements.hpp"
#include "replay/own_recording.hpp"
#include "replay/role_replay.hpp"

namespace voltlap::plant {
namespace {

constexpr double kVoltsPerCount = 1e-4;  // of the firmware's cell voltages
constexpr double kOhmPerCount = 1e-6;    // of its resistances

ReplayCar replayed_car(const VehicleParameters& car, const bms::Config& config) {
  ReplayCar out;
  out.cells = config.cells_in_series;
  out.thermistors = config.temperature_sensors;
  out.motor_constant_nm_per_a = 1e-6 * config.motor_constant_unm_per_a;
  out.full_brake_bar = car.brakes.full_pedal_pressure_bar;
  out.rest_current_a = 1e-3 * config.soc_start_current.raw();
  if (config.soc_method != bms::SocMethod::kNone) {
    out.capacity_ah = 1e-3 * config.capacity_mah;
    for (std::size_t k = 0; k < config.ocv.count; ++k) {
      out.ocv.emplace_back(1e-6 * config.ocv.soc[k].raw(), kVoltsPerCount * config.ocv.voltage[k].raw());
    }
    double sum = 0.0;
    for (std::size_t k = 0; k < config.resistance.count; ++k) sum += config.resistance.resistance[k].raw();
    out.resistance_ohm = kOhmPerCount * sum / std::max<double>(1.0, config.resistance.count);
  }
  out.cell_min_v = kVoltsPerCount * config.cell_voltage_min.raw();
  out.cell_max_v = kVoltsPerCount * config.cell_voltage_max.raw();
  return out;
}

/// Of every cell, where the firmware has a filter of each.
std::vector<CellEstimate> estimates_of(const app::BmsNode& node) {
  const bms::Config& config = node.config();
  const bms::SocEstimate& soc = node.state().soc;
  std::vector<CellEstimate> out;
  if (config.soc_method != bms::SocMethod::kEkf || !soc.valid) return out;
  const auto unit = [](std::int32_t value) { return static_cast<double>(value) / bms::kUnit; };
  const auto deviation = [](std::int32_t variance) {
    return std::sqrt(std::max(0.0, std::ldexp(static_cast<double>(variance), -bms::kVarianceBits)));
  };
  for (std::size_t i = 0; i < config.cells_in_series; ++i) {
    const bms::CellFilter& filter = soc.filter.cell[i].filter;
    const double capacity_ah = 1e-3 * config.capacity_mah / (1.0 + unit(filter.fade));
    out.push_back({static_cast<int>(i) + 1, 1e-6 * bms::cell_soc(soc, i).raw(), unit(filter.rho),
                   deviation(filter.p.rr), capacity_ah, capacity_ah * deviation(filter.p.ff)});
  }
  return out;
}

ReplayResult of_own(const ReplayAsked& asked, const DataFolder& data) {
  ReplayResult out;
  out.pack = asked.pack.empty() ? "vtm16e" : asked.pack;
  out.map = "our own bus, frame by frame";
  const LoadedVehicle car = pack_of_own(data, out.pack, asked.settings);
  const bms::Config config = bms_config(car.parameters, car.origin);
  FirmwareLoop firmware(config, master_config(car.parameters, car.origin));
  ProgressLine progress("replay");
  progress.show("reading " + asked.log, 0.0);
  const OwnRecording recording = read_own_recording(asked.log);
  progress.show("replaying", 0.5);
  out.log = asked.log;
  replay_own(recording, firmware, kVoltsPerCount * config.cell_voltage_min.raw(),
             kVoltsPerCount * config.cell_voltage_max.raw(), out);
  out.cells_recorded = out.cells;
  out.estimates = estimates_of(firmware.bms_node());
  out.disagreements = find_disagreements(out);
  progress.end();
  return out;
}

}  // namespace

ReplayResult replay_by_role(const ReplayAsked& asked, const MapFinding& finding, const DataFolder& data,
                            const std::function<void(const std::string&, double)>& progress) {
  finding.check_needed(!asked.map.empty());
  progress("reading " + asked.log, 0.0);
  std::optional<RoleMap> map = finding.find(asked.log);
  if (!asked.map.empty()) map = load_role_map(data.find("maps", asked.map, "--map"));
  const DriveLog log = read_drive_log(asked.log, map ? &*map : nullptr, data);
  const LoadedVehicle car = pack_of_log(data, asked.pack, asked.settings, log);
  bms::Config config = bms_config(car.parameters, car.origin);
  master::Config master = master_config(car.parameters, car.origin);
  master.inverter_excess_max = master::check::kInverterExcessMax;  // the log's inverter obeys the log's controller
  config.inverter_protocol = master.inverter_protocol = InverterProtocol::kPhaseCurrent;  // as its readings are sent on
  master.motor_speed_max = min(master.motor_speed_max, master::check::kMotorSpeedMax);
  FirmwareLoop firmware(config, master);
  progress("replaying", 0.5);
  ReplayResult out;
  out.log = asked.log;
  out.map = log.map;
  out.pack = asked.pack;
  replay_roles(log, replayed_car(car.parameters, config), pedal_sensors(master), !asked.pack.empty(), firmware, out);
  if (out.has_cell_model()) out.estimates = estimates_of(firmware.bms_node());
  out.estimates.resize(std::min(out.estimates.size(), out.cells_recorded));  // the others have their share of the pack
  out.disagreements = find_disagreements(out);
  return out;
}

void add_settings(CLI::App& command, ReplayAsked& asked) {
  command
      .add_option("--set", asked.settings,
                  "Change the pack or the firmware (voltlap list keys), key=value, one or several")
      ->type_name("KEY=VALUE")
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
}

bool is_replayed_by_frame(const ReplayAsked& asked, const MapFinding& finding) {
  return asked.map.empty() && !finding.is_asked() && is_own_recording(asked.log);
}

ReplayResult run_replay(const ReplayAsked& asked, const MapFinding& finding, const DataFolder& data) {
  if (is_replayed_by_frame(asked, finding)) return of_own(asked, data);
  ProgressLine progress("replay");
  return replay_by_role(asked, finding, data,
                        [&](const std::string& what, double fraction) { progress.show(what, fraction); });
}

}  // namespace voltlap::plant
