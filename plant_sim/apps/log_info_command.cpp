// SPDX-License-Identifier: Apache-2.0
#include "apps/log_info_command.hpp"

#include <fmt/format.h>

#include "apps/exit_code.hpp"
#include "apps/flag_checks.hpp"
#include "apps/log_group.hpp"
#include "apps/progress_line.hpp"
#include "io/atomic_file.hpp"
#include "io/logs/can/survey_findings.hpp"

namespace voltlap::plant {
namespace {

RecordingSurvey surveyed(const RecordingInput& input, const DbcSet& dbc) {
  const auto recording = input.open(dbc);
  ProgressLine progress("reading " + input.path());
  return survey(*recording, dbc, [&](std::size_t frames) { progress.show(fmt::format("{} frames", frames), 0.0); });
}

void write_json(const std::string& path, const std::string& text) {
  if (path.empty()) return;
  AtomicFile file(path);
  file.write(text);
  file.commit();
}

}  // namespace

LogInfoCommand::LogInfoCommand(CLI::App& app)
    : command_(log_group(app).add_subcommand("info", "What is in a recording: frames, rates, bus load, signals")) {
  recording_.add(*command_);
  command_->add_option("--bit-rate", bit_rate_kbit_s_, "Bit rate of the buses [kbit/s], for their load")
      ->check(number_between(1.0, 20000.0))
      ->capture_default_str();
  add_output_file(*command_, "--json", json_, "Write all of it as JSON; -: to standard output");
  command_->footer(
      "Example: voltlap log info drive.log.gz --dbc car.dbc\n"
      "Exit code: 0; 1 the file breaks off, what stands before it is shown; 2 usage or input.");
}

int LogInfoCommand::run(const DataFolder& data) {
  const DbcSet dbc = recording_.dbc(data);
  const RecordingSurvey found = surveyed(recording_, dbc);
  write_json(json_, json_.empty() ? "" : survey_json(recording_.path(), found, dbc, 1e3 * bit_rate_kbit_s_));
  std::FILE* stream = summary_stream({json_});
  fmt::print(stream, "{}", survey_text(recording_.path(), found, 1e3 * bit_rate_kbit_s_));
  const std::size_t wrong = findings(found, dbc).size();
  if (wrong > 0) fmt::print(stream, "\n  {} findings: voltlap log check {} lists them\n", wrong, recording_.path());
  return found.summary.broken.empty() ? kExitOk : kExitDefects;
}

LogCheckCommand::LogCheckCommand(CLI::App& app)
    : command_(log_group(app).add_subcommand("check", "What is wrong with a recording, every kind with its number")) {
  recording_.add(*command_);
  add_output_file(*command_, "--json", json_, "Write it as JSON; -: to standard output");
  command_->footer(
      "Example: voltlap log check drive.log.gz --dbc car.dbc\n"
      "Exit code: 0 nothing is wrong, 1 something is, 2 usage or input.");
}

int LogCheckCommand::run(const DataFolder& data) {
  constexpr double kBitRate = 500e3;
  const DbcSet dbc = recording_.dbc(data);
  const RecordingSurvey found = surveyed(recording_, dbc);
  write_json(json_, json_.empty() ? "" : survey_json(recording_.path(), found, dbc, kBitRate));
  const std::vector<Finding> wrong = findings(found, dbc);
  std::FILE* stream = summary_stream({json_});
  fmt::print(stream, "{}: {}\n  {}\n", recording_.path(), found.format, account_text(found.summary));
  for (const Finding& finding : wrong) fmt::print(stream, "  {}: {}\n", finding.kind, finding.text);
  if (wrong.empty()) fmt::print(stream, "  nothing is wrong with it\n");
  fmt::print(stream, "{}{}", dbc_faults_text(dbc), checksum_text(found));
  return wrong.empty() ? kExitOk : kExitDefects;
}

}  // namespace voltlap::plant
