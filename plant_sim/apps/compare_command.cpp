// SPDX-License-Identifier: Apache-2.0
#include "apps/compare_command.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <optional>

#include "apps/exit_code.hpp"
#include "apps/flag_checks.hpp"
#include "core/errors.hpp"
#include "io/atomic_file.hpp"
#include "race/report/run_comparison.hpp"

namespace voltlap::plant {
namespace {

/// A result that would take the place of a run that is read.
void refuse_inputs(const std::vector<std::string>& runs, const std::string& flag, const std::string& file) {
  for (const std::string& run : runs) {
    std::error_code ignored;
    if (file == run || (!file.empty() && std::filesystem::equivalent(file, run, ignored))) {
      throw InputError(flag, file + ", one of the runs", "a file of its own", "Choose another name");
    }
  }
}

}  // namespace

CompareCommand::CompareCommand(CLI::App& app)
    : command_(app.add_subcommand("compare", "Two to five runs over each other: inputs, results, laps, time behind")) {
  command_->add_option("RUN.json", files_, "Results of endurance --json on one course; the first is compared with")
      ->required();
  add_output_file(*command_, "--json", json_, "Write the comparison as JSON; -: to standard output");
  add_output_file(*command_, "--report", report_, "Write a report as one HTML file for any browser, offline");
  command_->footer(
      "Example: voltlap compare base.json heavy.json --report compare.html\n"
      "Differences are run minus the first run; energies by lap stand in --report and --json.\n"
      "Exit code: 0, also when one of the runs failed (it says so); 2 usage or input.");
}

int CompareCommand::run(const DataFolder&) {
  refuse_shared_files({{"--json", json_}, {"--report", report_}});
  refuse_inputs(files_, "--json", json_);
  refuse_inputs(files_, "--report", report_);
  const RunComparison comparison = compare_runs(files_);
  std::optional<AtomicFile> json, report;
  if (!json_.empty()) json.emplace(json_).write(comparison_json(comparison));
  if (!report_.empty()) report.emplace(report_).write(comparison_page(comparison));
  if (json) json->complete();
  if (report) report->complete();
  if (json) json->commit();
  if (report) report->commit();
  fmt::print(summary_stream({json_, report_}), "{}", comparison_text(comparison));
  return kExitOk;
}

}  // namespace voltlap::plant
