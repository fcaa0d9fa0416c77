// SPDX-License-Identifier: Apache-2.0
#include "apps/log_plot_command.hpp"

#include <fmt/format.h>

#include <cstdio>

#include "apps/exit_code.hpp"
#include "apps/flag_checks.hpp"
#include "apps/log_group.hpp"
#include "apps/progress_line.hpp"
#include "core/input_files.hpp"
#include "io/atomic_file.hpp"
#include "io/logs/plot/log_plot.hpp"

namespace voltlap::plant {
namespace {

constexpr std::size_t kToldNotes = 6;

/// A word as a shell takes it.
std::string shell_word(const std::string& word) {
  if (word.find_first_of(" *?[]()'\"$&;|<>\\") == std::string::npos) return word;
  std::string out = "'";
  for (const char c : word) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

}  // namespace

LogPlotCommand::LogPlotCommand(CLI::App& app)
    : command_(log_group(app).add_subcommand("plot", "Signals of a recording over time, as one HTML page of charts")) {
  command_
      ->add_option("LOG", sources_.recording,
                   "A recording of a CAN bus as for log info, or a table (CSV); plain, gzip or zstd")
      ->required();
  command_
      ->add_option("--dbc", sources_.dbc_files,
                   "DBC file (KCD, SYM, ARXML as well) that knows the frames; may be given again")
      ->allow_extra_args(false);
  command_->add_option("--map", sources_.map,
                       "Role map: without --dbc the signals are its roles, in SI units; beside it the map's intervals "
                       "are used");
  command_
      ->add_option("--signals", signals_,
                   "Names or patterns (BmsStatus.PackVoltage, PackVoltage, '*Temp*'), separated by commas; default: "
                   "those that move most")
      ->delimiter(',')
      ->allow_extra_args(false);
  command_->add_option("--from", from_s_, "Only from this time on [s after the recording's beginning]")
      ->check(number_from_zero());
  command_->add_option("--to", to_s_, "Only up to this time [s after the recording's beginning]")
      ->check(number_from_zero());
  add_output_file(*command_, "--report", report_, "The page")->required();
  command_->footer(
      "Charts of one unit are gathered; all show the same stretch. Of long recordings each stretch keeps its lowest "
      "and\nhighest value, so no spike is lost. A table needs no DBC file: every column with numbers is a signal.\n"
      "Example: voltlap log plot drive.log.gz --dbc car.dbc --signals 'Pack*,*Temp*' --report drive.html\n"
      "Exit code: 0; 2 usage, input, or a page that cannot be written.");
}

std::string LogPlotCommand::command_line() const {
  std::string out = "voltlap log plot " + shell_word(sources_.recording);
  for (const std::string& file : sources_.dbc_files) out += " --dbc " + shell_word(file);
  if (!sources_.map.empty()) out += " --map " + shell_word(sources_.map);
  if (!signals_.empty()) {
    std::string names;
    for (const std::string& name : signals_) names += (names.empty() ? "" : ",") + name;
    out += " --signals " + shell_word(names);
  }
  if (from_s_) out += fmt::format(" --from {:g}", *from_s_);
  if (to_s_) out += fmt::format(" --to {:g}", *to_s_);
  return out + " --report " + shell_word(report_);
}

int LogPlotCommand::run(const DataFolder& data) {
  note_input(sources_.recording);
  for (const std::string& file : sources_.dbc_files) note_input(file);
  AtomicFile page(report_);
  ProgressLine progress("plotting");
  const auto recorded = open_signals(sources_, data);
  LogPlotRequest request;
  request.recording = sources_.recording;
  request.signals = signals_;
  request.from_s = from_s_;
  request.to_s = to_s_;
  request.version = VOLTLAP_VERSION;
  request.command = command_line();
  request.progress = [&](const std::string& what, double fraction) { progress.show(what, fraction); };
  const LogPlot plot = plot_log(*recorded, request);
  progress.end();
  page.write(plot.page);
  page.commit();
  std::FILE* stream = summary_stream({report_});
  fmt::print(stream, "{}: {} chart{} of {}\n", report_, plot.charts, plot.charts == 1 ? "" : "s", plot.choice);
  for (std::size_t k = 0; k < std::min(plot.notes.size(), kToldNotes); ++k)
    fmt::print(stream, "  {}\n", plot.notes[k]);
  if (plot.notes.size() > kToldNotes)
    fmt::print(stream, "  and {} more remarks, in the page\n", plot.notes.size() - kToldNotes);
  return kExitOk;
}

}  // namespace voltlap::plant
