// SPDX-License-Identifier: Apache-2.0
#include "apps/validate_command.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <optional>
#include <utility>

#include "apps/exit_code.hpp"
#include "apps/flag_checks.hpp"
#include "apps/other_programs.hpp"
#include "core/demand.hpp"
#include "core/errors.hpp"
#include "io/atomic_file.hpp"
#include "learn/identify/preparation/capacity.hpp"
#include "learn/identify/recording/quantised_temperature.hpp"
#include "learn/validate/count_hint.hpp"
#include "learn/validate/validation_json.hpp"
#include "learn/validate/validation_report.hpp"
#include "learn/validate/validation_text.hpp"

namespace voltlap::plant {
namespace {

constexpr int kStudyCells = 24;  // reference study, 2016, Appendix C

}  // namespace

ValidateCommand::ValidateCommand(CLI::App& app)
    : command_(
          app.add_subcommand("validate", what_it_does("validate"))) {
  command_->add_option("cell", cell_, "Cell file: name or path")->required();
  recordings_.add(*command_)->required();
  command_
      ->add_option("--temperature", study_.validation.temperature_c,
                   "degC of recordings that have no temperature column")
      ->check(number_between(-40.0, 80.0, "In degC; correct the number, or leave the flag out"))
      ->capture_default_str();
  command_->add_flag("--reductions", study_.reductions, "What each table costs without its current or temperature");
  command_->add_flag("--sensitivity", study_.sensitivity,
                     "How far the tables move with current and temperature; RMS with each parameter 1 and 5 % off");
  command_->add_flag("--thermal", study_.thermal,
                     "Fit heat capacity, cooling, lag of the surface and entropy to recorded temperatures");
  command_
      ->add_option("--pack", study_.pack_cells,
                   "One cell that stands for N against N cells, with the first file's current")
      ->type_name("N")
      ->check(whole_number(1, 144));
  command_->add_flag("--full", full_, "All four (--pack 24; --thermal where a temperature was recorded)");
  add_output_file(*command_, "--json", json_, "Write everything as JSON");
  add_output_file(*command_, "--csv", csv_, "Write the error over time as CSV (or .csv.gz)");
  add_output_file(*command_, "--report", report_, "Write everything as one HTML page with charts over time");
  command_->footer(
      "RMS and bias are weighted by time and count discharge strokes; the bias is model minus recording. Where "
      "the\n"
      "reference study of 2016 has a number, it stands beside.\n"
      "Example: voltlap validate cell.toml drive.csv.gz --sensitivity --json errors.json");
}

std::vector<CellLog> ValidateCommand::read(const DataFolder& data, ProgressLine& progress) const {
  const std::vector<std::optional<RoleMap>> maps = recordings_.role_maps(data);
  std::vector<CellLog> logs;
  for (const std::string& file : recordings_.files) {
    progress.show("reading " + file,
                  static_cast<double>(logs.size()) / static_cast<double>(recordings_.files.size()));
    const std::optional<RoleMap>& map = maps.at(logs.size());
    logs.push_back(read_cell_log(file, map ? &*map : nullptr, data, recordings_.whole()));
    smooth_quantised_temperature(logs.back());  // as identify does: the file's tables belong to it
  }
  return logs;
}

StudyOptions ValidateCommand::options(const std::vector<CellLog>& logs, ProgressLine& progress) const {
  StudyOptions out = study_;
  out.validation.temperature_told = command_->get_option("--temperature")->count() > 0;
  if (full_) {
    out.reductions = out.sensitivity = true;
    if (out.pack_cells == 0) out.pack_cells = kStudyCells;
    for (const CellLog& log : logs) out.thermal = out.thermal || !log.temperature_c.empty();
  }
  out.progress = [&](const std::string& what, double fraction) { progress.show(what, fraction); };
  return out;
}

std::vector<std::string> ValidateCommand::add_hints(const CellParameters& cell, const std::vector<CellLog>& logs,
                                                    ValidationStudy& study) const {
  VOLTLAP_DEMAND(study.files.size() == logs.size());
  const CellModel model(cell);
  const CellCounts counts{recordings_.cells_in_series, recordings_.cells_in_parallel};
  std::vector<std::string> hints(logs.size());
  for (std::size_t k = 0; k < logs.size(); ++k) {
    FileValidation& file = study.files[k];
    const auto hint = count_hint(model, logs[k], study_.validation, counts, file.rms_v);
    if (!hint) continue;
    hints[k] = *hint;
    file.repairs.push_back(*hint);
  }
  return hints;
}

namespace {

/// No model of a cell is so wrong about it; that of another cell is.
void require_of_this_cell(const CellParameters& cell, const std::vector<CellLog>& logs, const ValidationStudy& study,
                          const std::vector<std::string>& hints) {
  constexpr double kOther_v = 1.0;
  for (std::size_t k = 0; k < logs.size(); ++k) {
    const FileValidation& file = study.files[k];
    if (file.rms_v < kOther_v) continue;
    const std::string hint = hints[k].empty() ? std::string() : " " + hints[k] + ".";
    throw InputError(logs[k].path,
                     fmt::format("an error of {:.3g} V RMS, with {:.4g} Ah moved by a cell of {:.4g} Ah", file.rms_v,
                                 moved_ah(logs[k], CurrentHold::kLinear), cell.capacity_ah),
                     fmt::format("a recording of {}", cell.name),
                     "Check the cell, --cells-in-series, --cells-in-parallel and the units." + hint);
  }
}

}  // namespace

std::string ValidateCommand::command_line() const {
  std::string out = "voltlap validate " + cell_;
  for (const std::string& file : recordings_.files) out += " " + file;
  for (const CLI::Option* option : command_->get_options()) {
    const bool flag = option->get_name().starts_with("--") && option->count() > 0;
    if (!flag || option->get_name() == "--report") continue;
    out += " " + option->get_name();
    if (option->get_items_expected_max() > 0) out += " " + option->results().front();
  }
  return out + " --report " + report_;
}

int ValidateCommand::run(const DataFolder& data) {
  refuse_shared_files({{"--json", json_},
                       {"--csv", csv_},
                       {"--report", report_},
                       {"--write-map", recordings_.finding.write_map}});
  const CellParameters cell = load_cell(data, cell_, "cell");
  std::optional<AtomicFile> json, csv, report;
  if (!json_.empty()) json.emplace(json_);
  if (!csv_.empty()) csv.emplace(csv_);
  if (!report_.empty()) report.emplace(report_);
  ProgressLine progress("validating");
  const std::vector<CellLog> logs = read(data, progress);
  ValidationStudy study = study_validation(cell, logs, options(logs, progress));
  const std::vector<std::string> hints = add_hints(cell, logs, study);
  progress.end();
  require_of_this_cell(cell, logs, study, hints);

  std::FILE* to = summary_stream({json_, csv_, report_});
  for (const FileValidation& file : study.files) fmt::print(to, "{}", file_text(file));
  fmt::print(to, "{}", study_text(cell, study));
  if (csv) write_error_table(*csv, cell, study, VOLTLAP_VERSION);
  if (json) json->write(validation_json(cell, study, VOLTLAP_VERSION));
  if (report) report->write(validation_report(cell, study, {VOLTLAP_VERSION, command_line()}));
  for (auto* file : {&csv, &json, &report}) {
    if (*file) (*file)->complete();
  }
  for (auto* file : {&csv, &json, &report}) {
    if (*file) (*file)->commit();
  }
  return kExitOk;
}

}  // namespace voltlap::plant
