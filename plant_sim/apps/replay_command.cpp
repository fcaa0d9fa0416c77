// SPDX-License-Identifier: Apache-2.0
#include "apps/replay_command.hpp"

#include <fmt/format.h>

#include <cstdio>

#include "apps/exit_code.hpp"
#include "apps/firmware_config.hpp"
#include "apps/firmware_loop.hpp"
#include "apps/flag_checks.hpp"
#include "apps/other_programs.hpp"
#include "apps/progress_line.hpp"
#include "apps/replay_by_role.hpp"
#include "apps/replay_pack.hpp"
#include "replay/disagreements.hpp"
#include "replay/own_recording.hpp"
#include "replay/replay_baseline.hpp"
#include "replay/replay_text.hpp"

namespace voltlap::plant {
namespace {

constexpr double kVoltsPerCount = 1e-4;  // of the firmware's cell voltages

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
  outputs_.add(*command_);
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
  ProgressLine progress("replay");
  return replay_by_role({log_, map_, pack_, settings_, finding_}, data,
                        [&](const std::string& what, double fraction) { progress.show(what, fraction); });
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
      {{"--json", outputs_.json}, {"--csv", outputs_.csv}, {"--report", outputs_.report},
       {"--write-map", finding_.write_map}});
  const bool own = map_.empty() && !finding_.is_asked() && is_own_recording(log_);
  const ReplayResult result = own ? of_own(data) : by_role(data);
  outputs_.write(result);
  std::FILE* const to = outputs_.stream();
  fmt::print(to, "{}", replay_text(result));
  const bool changed = report_changes(result, to), differs = result.comparison && !result.comparison->identical();
  return changed || differs ? kExitDefects : kExitOk;
}

}  // namespace voltlap::plant
