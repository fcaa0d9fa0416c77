// SPDX-License-Identifier: Apache-2.0
#include "apps/replay_second_run.hpp"

#include <fmt/format.h>

#include <fstream>
#include <sstream>

#include "apps/progress_line.hpp"
#include "core/errors.hpp"
#include "io/python_module.hpp"
#include "io/temporary_folder.hpp"
#include "replay/replay_baseline.hpp"
#include "replay/replay_text.hpp"

namespace voltlap::plant {
namespace {

std::string content_of(const std::string& path) {
  std::ifstream file(path);
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

/// The arguments that ask another program for the same replay.
std::vector<std::string> arguments_of(const ReplayAsked& asked, const MapFinding& finding) {
  std::vector<std::string> out = {"replay", asked.log};
  if (!asked.map.empty()) out.insert(out.end(), {"--map", asked.map});
  if (!asked.pack.empty()) out.insert(out.end(), {"--pack", asked.pack});
  for (const std::string& file : finding.dbc_files) out.insert(out.end(), {"--dbc", file});
  if (!asked.settings.empty()) out.emplace_back("--set");
  out.insert(out.end(), asked.settings.begin(), asked.settings.end());
  return out;
}

}  // namespace

SecondRun run_with(const ReplayAsked& asked, const std::vector<std::string>& settings, const MapFinding& finding,
                   const DataFolder& data, const ReplayResult& first) {
  ReplayAsked changed = asked;
  changed.settings.insert(changed.settings.end(), settings.begin(), settings.end());
  const ReplayResult second = run_replay(changed, finding, data);
  SecondRun out{"with " + fmt::format("{}", fmt::join(settings, " ")), "the run without it", second.rows, {}};
  out.changes = changes_between(replay_json(first, VOLTLAP_VERSION), replay_json(second, VOLTLAP_VERSION));
  return out;
}

SecondRun run_by_commit(const ReplayAsked& asked, const std::string& commit, const MapFinding& finding,
                        const ReplayResult& present) {
  const TemporaryFolder folder;
  const std::string json = folder.path() + "/replay.json", csv = folder.path() + "/replay.csv";
  std::vector<std::string> arguments = {commit, "--"};
  const std::vector<std::string> same = arguments_of(asked, finding);
  arguments.insert(arguments.end(), same.begin(), same.end());
  arguments.insert(arguments.end(), {"--json", json, "--csv", csv});
  ProgressLine progress("replay");
  progress.show("building the firmware of " + commit + ", minutes when it is the first time", 0.1);
  const std::string name = run_python_module("voltlap_firmware_at", arguments);
  progress.end();
  SecondRun out{"firmware of " + commit, "the firmware of " + name, rows_of_csv(content_of(csv)), {}};
  out.changes = changes_between(content_of(json), replay_json(present, VOLTLAP_VERSION));
  return out;
}

}  // namespace voltlap::plant
