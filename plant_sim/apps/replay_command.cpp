// SPDX-License-Identifier: Apache-2.0
#include "apps/replay_command.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <optional>

#include "apps/exit_code.hpp"
#include "apps/firmware_config.hpp"
#include "apps/firmware_loop.hpp"
#include "apps/flag_checks.hpp"
#include "apps/other_programs.hpp"
#include "apps/progress_line.hpp"
#include "apps/replay_pack.hpp"
#include "io/atomic_file.hpp"
#include "io/logs/role_map.hpp"
#include "replay/disagreements.hpp"
#include "replay/own_recording.hpp"
#include "replay/replay_baseline.hpp"
#include "replay/replay_report.hpp"
#include "replay/replay_text.hpp"
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

}  // namespace

ReplayCommand::ReplayCommand(CLI::App& app) : command_(app.add_subcommand("replay", what_it_does("replay"))) {
  command_->add_option("LOG", log_, "Log of a car or a pack: CAN recording or table, plain or compressed")->required();
  command_->add_option("--map", map_,
                       "Role map: name or path; default: a shipped map that fits. A recording of our own bus is "
                       "replayed frame by frame without one, by role with one");
  finding_.add(*command_);
  command_->add_option("--pack", pack_,
                       "Cell, pack or vehicle file (TOML), name or path: what the firmware knows of the cells. Without "
                       "it SOC and limits say `no cell model`; of our own bus: the vehicle driven (default vtm16e)");
  add_output_file(*command_, "--json", json_, "Write the result as JSON; -: to standard output");
  add_output_file(*command_, "--csv", csv_, "Write a time series, ten rows a second");
  add_output_file(*command_, "--report", report_, "Write a report as one HTML file");
  command_->add_option("--baseline", baseline_,
                       "JSON of an earlier replay of this log: whatever has changed since is printed, value by value");
  command_
      ->add_option("--set", settings_,
                   "Change the pack or the firmware (voltlap list keys), key=value, one or several")
      ->type_name("KEY=VALUE")
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command_->footer(
      "Example: voltlap replay drive.log.gz --pack pack.toml --json replay.json --csv replay.csv\n"
      "A candump of our own car (voltlap endurance --candump run.log): voltlap replay run.log\n"
      "See docs/replay.md. Exit code: 0 the log was replayed; 1 frames of our own bus were not answered as recorded,\n"
      "or something has changed since the baseline; 2 usage or input, or a log that cannot be replayed, with why.");
}

ReplayResult ReplayCommand::of_own(const DataFolder& data) const {
  ReplayResult out;
  out.pack = pack_.empty() ? "vtm16e" : pack_;
  out.map = "our own bus, frame by frame";
  const LoadedVehicle car = pack_of_own(data, out.pack, settings_);
  const bms::Config config = bms_config(car.parameters, car.origin);
  FirmwareLoop firmware(config, master_config(car.parameters, car.origin));
  ProgressLine progress("replay");
  progress.show("reading " + log_, 0.0);
  const OwnRecording recording = read_own_recording(log_);
  progress.show("replaying", 0.5);
  out.log = log_;
  replay_own(recording, firmware, kVoltsPerCount * config.cell_voltage_min.raw(),
             kVoltsPerCount * config.cell_voltage_max.raw(), out);
  out.disagreements = find_disagreements(out);
  progress.end();
  return out;
}

ReplayResult ReplayCommand::by_role(const DataFolder& data) const {
  finding_.check_needed(!map_.empty());
  ProgressLine progress("replay");
  progress.show("reading " + log_, 0.0);
  std::optional<RoleMap> map = finding_.find(log_);
  if (!map_.empty()) map = load_role_map(data.find("maps", map_, "--map"));
  const DriveLog log = read_drive_log(log_, map ? &*map : nullptr, data);
  const LoadedVehicle car = pack_of_log(data, pack_, settings_, log);
  const bms::Config config = bms_config(car.parameters, car.origin);
  const master::Config master = master_config(car.parameters, car.origin);
  FirmwareLoop firmware(config, master);
  progress.show("replaying", 0.5);
  ReplayResult out;
  out.log = log_;
  out.map = log.map;
  out.pack = pack_;
  replay_roles(log, replayed_car(car.parameters, config), pedal_sensors(master), !pack_.empty(), firmware, out);
  out.disagreements = find_disagreements(out);
  progress.end();
  return out;
}

/// Prints what has changed; true where something has.
bool ReplayCommand::report_changes(const ReplayResult& result, std::FILE* to) const {
  constexpr std::size_t kShown = 40;
  if (baseline_.empty()) return false;
  const std::vector<std::string> changes = changes_since(baseline_, replay_json(result, VOLTLAP_VERSION));
  if (changes.empty()) fmt::print(to, "\nNothing has changed since {}\n", baseline_);
  if (!changes.empty()) fmt::print(to, "\nChanged since {}: {} values\n", baseline_, changes.size());
  for (std::size_t k = 0; k < changes.size() && k < kShown; ++k) fmt::print(to, "  {}\n", changes[k]);
  if (changes.size() > kShown) fmt::print(to, "  and {} more\n", changes.size() - kShown);
  return !changes.empty();
}

int ReplayCommand::run(const DataFolder& data) {
  refuse_shared_files(
      {{"--json", json_}, {"--csv", csv_}, {"--report", report_}, {"--write-map", finding_.write_map}});
  const bool own = map_.empty() && !finding_.is_asked() && is_own_recording(log_);
  const ReplayResult result = own ? of_own(data) : by_role(data);
  const auto write = [](const std::string& path, const auto& text) {
    if (path.empty()) return;
    AtomicFile file(path);
    file.write(text());
    file.commit();
  };
  write(json_, [&] { return replay_json(result, VOLTLAP_VERSION); });
  write(csv_, [&] { return replay_csv(result); });
  write(report_, [&] { return replay_report(result, VOLTLAP_VERSION); });
  std::FILE* const to = summary_stream({json_, csv_, report_});
  fmt::print(to, "{}", replay_text(result));
  const bool changed = report_changes(result, to), differs = result.comparison && !result.comparison->identical();
  return changed || differs ? kExitDefects : kExitOk;
}

}  // namespace voltlap::plant
