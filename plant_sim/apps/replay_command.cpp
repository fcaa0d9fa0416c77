// SPDX-License-Identifier: Apache-2.0
#include "apps/replay_command.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>

#include "apps/exit_code.hpp"
#include "apps/flag_checks.hpp"
#include "apps/other_programs.hpp"
#include "apps/replay_season.hpp"
#include "apps/replay_second_run.hpp"
#include "core/errors.hpp"
#include "replay/replay_baseline.hpp"
#include "replay/replay_text.hpp"

namespace voltlap::plant {
namespace {

void print_changes(const std::vector<std::string>& changes, const std::string& since, std::FILE* to) {
  constexpr std::size_t kShown = 40;
  if (changes.empty()) fmt::print(to, "\nNothing has changed since {}\n", since);
  if (!changes.empty()) fmt::print(to, "\nChanged since {}: {} values\n", since, changes.size());
  for (std::size_t k = 0; k < changes.size() && k < kShown; ++k) fmt::print(to, "  {}\n", changes[k]);
  if (changes.size() > kShown) fmt::print(to, "  and {} more\n", changes.size() - kShown);
}

}  // namespace

ReplayCommand::ReplayCommand(CLI::App& app) : command_(app.add_subcommand("replay", what_it_does("replay"))) {
  command_
      ->add_option("LOG", asked_.log,
                   "Log of a car or a pack: CAN recording or table, plain or compressed; or a folder of logs: one line "
                   "for each, --json is a folder, too")
      ->required();
  command_->add_option("--map", asked_.map,
                       "Role map: name or path; default: a shipped map that fits. A recording of our own bus is "
                       "replayed frame by frame without one, by role with one");
  finding_.add(*command_);
  command_->add_option("--pack", asked_.pack,
                       "Cell, pack or vehicle file (TOML), name or path: what the firmware knows of the cells. Without "
                       "it SOC and limits say `no cell model`; of our own bus: the vehicle driven (default vtm16e)");
  outputs_.add(*command_);
  command_->add_option("--baseline", baseline_,
                       "JSON of an earlier replay of this log: whatever has changed since is printed, value by value. "
                       "Of a folder of logs: the folder that --json was")
      ->type_name("FILE");
  command_
      ->add_option("--what-if", what_if_,
                   "Replay once more with these settings changed; both are compared, in the report too. One or several")
      ->type_name("KEY=VALUE")
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command_->add_option("--firmware", firmware_,
                       "Replay with the firmware of this commit, too, built on first use, in minutes; both are "
                       "compared")
      ->type_name("COMMIT");
  add_settings(*command_, asked_);
  command_->footer(
      "Example: voltlap replay drive.log.gz --pack pack.toml --json replay.json --csv replay.csv\n"
      "A candump of our own car (voltlap endurance --candump run.log): voltlap replay run.log\n"
      "See docs/replay.md. Exit code: 0 the log was replayed; 1 frames of our own bus were not answered as recorded,\n"
      "or something has changed since the baseline or the commit; 2 usage or input, or a log that cannot be replayed,\n"
      "with why.");
}

/// Of a folder only what has one answer a log.
int ReplayCommand::run_folder(const DataFolder& data) const {
  const std::pair<const char*, bool> kOfOne[] = {{"--csv", !outputs_.csv.empty()},
                                                 {"--report", !outputs_.report.empty()},
                                                 {"--write-map", !finding_.write_map.empty()},
                                                 {"--what-if", !what_if_.empty()},
                                                 {"--firmware", !firmware_.empty()}};
  for (const auto& [flag, given] : kOfOne) {
    if (given) throw InputError(flag, asked_.log + ", a folder", "one log", "Replay that log by itself");
  }
  const auto replay = [&](const std::string& log) {
    ReplayAsked asked = asked_;
    asked.log = log;
    return run_replay(asked, finding_, data);
  };
  return replay_season({asked_.log, outputs_.json, baseline_, replay}, stdout);
}

int ReplayCommand::run(const DataFolder& data) {
  if (std::filesystem::is_directory(asked_.log)) return run_folder(data);
  refuse_shared_files(
      {{"--json", outputs_.json}, {"--csv", outputs_.csv}, {"--report", outputs_.report},
       {"--write-map", finding_.write_map}});
  if (!what_if_.empty() && !firmware_.empty()) {
    throw InputError("--what-if and --firmware", "both", "one second run", "Ask for one, then for the other");
  }
  ReplayResult result = run_replay(asked_, finding_, data);
  if (!what_if_.empty()) result.second = run_with(asked_, what_if_, finding_, data, result);
  if (!firmware_.empty()) result.second = run_by_commit(asked_, firmware_, finding_, result);
  outputs_.write(result);
  std::FILE* const to = outputs_.stream();
  fmt::print(to, "{}", replay_text(result));
  if (result.second) print_changes(result.second->changes, result.second->since, to);
  std::vector<std::string> changes;
  if (!baseline_.empty()) {
    changes = changes_since(baseline_, replay_json(result, VOLTLAP_VERSION));
    print_changes(changes, baseline_, to);
  }
  const bool changed = !changes.empty() || (!firmware_.empty() && !result.second->changes.empty());
  return changed || (result.comparison && !result.comparison->identical()) ? kExitDefects : kExitOk;
}

}  // namespace voltlap::plant
