// SPDX-License-Identifier: Apache-2.0
#include "apps/bench_test_command.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdio>
#include <filesystem>
#include <limits>
#include <optional>

#include "apps/exit_code.hpp"
#include "apps/flag_checks.hpp"
#include "apps/other_programs.hpp"
#include "apps/progress_line.hpp"
#include "apps/run_recorder.hpp"
#include "core/errors.hpp"
#include "learn/bench/plan_file.hpp"

namespace voltlap::plant {
namespace {

/// Keys of the cell go to the cell file, all others to the plan.
bool is_cell_key(const std::string& setting) {
  return setting.starts_with("cell.");
}

/// A cell file alone: the battery of some car needs everything else of that car, and the bench nothing of it.
CellParameters load_cell(const DataFolder& data, const std::string& name, std::vector<std::string> settings) {
  const std::string path = std::filesystem::absolute(data.find("cells", name, "--cell")).string();
  settings.push_back("battery.cell=" + path);
  return load_vehicle(data, "vtm16e", settings).parameters.cell;
}

std::string results_table(const Forecast& forecast, const std::vector<TestResult>& results) {
  std::string out = fmt::format("  {:<12} {:>9} {:>9} {:>7} {:>10} {:>8} {:>12}  {}\n", "test", "duration",
                                "forecast", "pulses", "charge", "lowest", "cells", "ended by");
  for (std::size_t i = 0; i < results.size(); ++i) {
    const TestForecast& test = results[i].summary;
    const std::string by = test.end == TestEnd::kProgram ? "" : fmt::format(", cell {}", results[i].end_cell);
    out += fmt::format("  {:<12} {:>9} {:>9} {:>7} {:>7.1f} Ah {:>6.3f} V {:>7} degC  {}{}\n", test.test.name,
                       hours_text(test.duration_s), hours_text(forecast.tests[i].duration_s), test.pulses,
                       test.charge_ah, test.lowest_v, fmt::format("{:.0f}-{:.0f}", test.coldest_c, test.hottest_c),
                       end_name(test.end), by);
  }
  return out;
}

int interrupted_text() {
  fmt::print(stderr, "Interrupted; tables of whole tests stay, the index was not written.\n");
  return exit_code_of_interrupt();
}

}  // namespace

BenchTestCommand::BenchTestCommand(CLI::App& app)
    : command_(app.add_subcommand("bench-test", what_it_does("bench-test"))) {
  command_->add_option("plan", plan_, "Name of a plan (voltlap list bench) or a TOML file")->type_name("PLAN");
  command_->add_option("--cell", cell_, "The cells' truth: name of a cell (voltlap list cells) or a TOML file")
      ->capture_default_str();
  command_->add_option("--out", out_, "Folder for the tables, <test>_cell<n>.csv, and their index campaign.json")
      ->type_name("DIR");
  command_->add_flag("--gz", gzip_, "Compress the tables");
  command_
      ->add_option("--set", settings_,
                   "Change keys of the plan, or of the cell as cell.KEY; key=value, may be given again")
      ->type_name("KEY=VALUE")
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command_->add_option("--seed", seed_, "Seed of cells, instruments and noise; the same seed gives the same tables")
      ->check(whole_number(0, std::numeric_limits<decltype(seed_)>::max()))
      ->capture_default_str();
  command_->add_flag("--dry-run", dry_run_, "Only say how long it will take and what it will excite");
  add_output_file(*command_, "--truth", truth_,
                  "Write what no instrument shows as CSV (or .csv.gz): voltage, SOC, temperature");
  add_output_file(*command_, "--json", json_, "Write forecast and results as JSON (the index)");
  add_output_file(*command_, "--report", report_,
                  "Write the campaign, or with --dry-run its rehearsal, as one HTML file");
  command_->footer(
      "Examples: voltlap bench-test pulse_15 --dry-run\n"
      "          voltlap bench-test pulse_15 --dry-run --report plan.html\n"
      "          voltlap bench-test random_resistors --out data --truth truth.csv.gz --set "
      "instruments.systematic=false\n"
      "Exit code: 0 done, 2 usage or input, 130 interrupted.");
}

Campaign BenchTestCommand::campaign(const DataFolder& data) const {
  std::vector<std::string> of_plan, of_cell;
  for (const std::string& setting : settings_) (is_cell_key(setting) ? of_cell : of_plan).push_back(setting);
  return Campaign(load_plan(data, plan_, of_plan), load_cell(data, cell_, of_cell), seed_);
}

void BenchTestCommand::refuse_files_that_clash() const {
  refuse_shared_files({{"--json", json_}, {"--truth", truth_}, {"--report", report_}});
  if (dry_run_ && !truth_.empty()) {
    throw InputError("--truth", "a file for the truth of a dry run", "no --truth: nothing is measured",
                     "Leave out one of the two");
  }
}

int BenchTestCommand::run(const DataFolder& data) {
  if (plan_.empty()) {
    throw InputError("plan", "no plan",
                     fmt::format("a name ({}) or a TOML file", fmt::join(data.names("bench"), ", ")),
                     "Name it behind bench-test");
  }
  refuse_files_that_clash();
  summary_ = summary_stream({json_, truth_, report_});
  const Campaign chosen = campaign(data);
  catch_interrupt();  // before there is a file that must not stay behind
  std::optional<AtomicFile> json;
  if (!json_.empty()) json.emplace(json_);
  std::optional<BenchReport> report;
  if (!report_.empty()) report.emplace(report_, chosen);
  CampaignFiles files(chosen, {dry_run_ ? "" : out_, gzip_, truth_});

  ProgressLine progress("rehearsing");
  const Forecast planned = forecast(chosen, [&](std::size_t test, double) {
    progress.show(chosen.tests()[test].name,
                  static_cast<double>(test) / static_cast<double>(chosen.tests().size()));
    return interrupted();
  });
  progress.end();
  if (planned.interrupted) return interrupted_text();
  fmt::print(summary_, "{}", forecast_text(chosen, planned));
  std::fflush(summary_);
  if (!dry_run_) {
    const int code = run_tests(chosen, planned, files, report ? &*report : nullptr);
    if (code != kExitOk) return code;
  } else if (report) {
    for (std::size_t i = 0; i < chosen.tests().size(); ++i) report->add(chosen.rehearse(i));
  }
  if (report) {
    report->finish(planned, files.results(), settings_);
    report->commit();
  }
  if (json) {
    json->write(files.index(planned, settings_));
    json->commit();
  }
  return kExitOk;
}

int BenchTestCommand::run_tests(const Campaign& chosen, const Forecast& planned, CampaignFiles& files,
                                BenchReport* report) {
  const auto begin = std::chrono::steady_clock::now();
  ProgressLine progress("on the bench");
  double done_s = 0.0;
  for (std::size_t i = 0; i < chosen.tests().size(); ++i) {
    const BenchRecord record = chosen.run(i, [&](double time_s) {
      progress.show(chosen.tests()[i].name, std::min(1.0, (done_s + time_s) / planned.bench_s));
      return interrupted();
    });
    if (record.end == TestEnd::kInterrupted) {
      progress.end();
      return interrupted_text();
    }
    done_s += planned.tests[i].duration_s;
    files.add(record);
    if (report != nullptr) report->add(record);
  }
  progress.end();
  files.commit(files.index(planned, settings_));
  const double wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  fmt::print(summary_, "\nOn the bench, seed {}:\n{}", seed_, results_table(planned, files.results()));
  if (out_.empty()) {
    fmt::print(summary_, "  nothing was written; give --out DIR for the tables\n");
  } else {
    fmt::print(summary_, "  {} tables and campaign.json in {}\n",
               chosen.tests().size() * static_cast<std::size_t>(chosen.plan().cells.count), out_);
  }
  fmt::print(summary_, "  computed in {:.1f} s\n", wall_s);
  return kExitOk;
}

}  // namespace voltlap::plant
