// SPDX-License-Identifier: Apache-2.0
#include "apps/validate_command.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <optional>

#include "apps/exit_code.hpp"
#include "apps/flag_checks.hpp"
#include "apps/progress_line.hpp"
#include "core/errors.hpp"
#include "report/atomic_file.hpp"
#include "validate/validation_json.hpp"
#include "validate/validation_text.hpp"

namespace voltlap::plant {
namespace {

constexpr int kStudyCells = 24;  // reference study, 2016, Appendix C

}  // namespace

ValidateCommand::ValidateCommand(CLI::App& app)
    : command_(
          app.add_subcommand("validate", "A cell file against recordings of that cell that it was not made from")) {
  command_->add_option("cell", cell_, "Cell file: name or path")->required();
  recordings_.add(*command_);
  command_
      ->add_option("--temperature", study_.validation.temperature_c, "degC of recordings that have no temperature column")
      ->capture_default_str();
  command_->add_flag("--reductions", study_.reductions, "What each table costs without its current or temperature");
  command_->add_flag("--sensitivity", study_.sensitivity,
                     "How far the tables move with current and temperature; RMS with each parameter 1 and 5 % off");
  command_->add_flag("--thermal", study_.thermal, "Fit heat capacity and cooling to the recorded temperatures");
  command_->add_option("--pack", study_.pack_cells, "One cell that stands for N against N cells, with the first file's current")
      ->type_name("N")
      ->check(whole_number(1, 144));
  command_->add_flag("--full", full_, "All four (--pack 24; --thermal where a temperature was recorded)");
  add_output_file(*command_, "--json", json_, "Write everything as JSON");
  add_output_file(*command_, "--csv", csv_, "Write the error over time as CSV (or .csv.gz)");
  command_->footer(
      "RMS and bias are weighted by time and count discharge strokes; the bias is model minus recording. Where the\n"
      "reference study of 2016 has a number, it stands beside.\n"
      "Example: voltlap validate cell.toml drive.csv.gz --sensitivity --json errors.json");
}

int ValidateCommand::run(const DataFolder& data) {
  if (!json_.empty() && json_ == csv_) {
    throw InputError("--json, --csv", "one file for both", "a file for each", "Give different names");
  }
  const CellParameters cell = load_cell(data, cell_, "cell");
  std::optional<AtomicFile> json, csv;
  if (!json_.empty()) json.emplace(json_);
  if (!csv_.empty()) csv.emplace(csv_);
  const std::optional<RoleMap> map = recordings_.role_map(data);
  ProgressLine progress("validating");
  std::vector<CellLog> logs;
  for (const std::string& file : recordings_.files) {
    progress.show("reading " + file, static_cast<double>(logs.size()) / static_cast<double>(recordings_.files.size()));
    logs.push_back(read_cell_log(file, map ? &*map : nullptr, data, recordings_.whole()));
  }
  StudyOptions options = study_;
  if (full_) {
    options.reductions = options.sensitivity = true;
    if (options.pack_cells == 0) options.pack_cells = kStudyCells;
    for (const CellLog& log : logs) options.thermal = options.thermal || !log.temperature_c.empty();
  }
  options.progress = [&](const std::string& what, double fraction) { progress.show(what, fraction); };
  const ValidationStudy study = study_validation(cell, logs, options);
  progress.end();

  std::FILE* to = summary_stream({json_, csv_});
  for (const FileValidation& file : study.files) fmt::print(to, "{}", file_text(file));
  fmt::print(to, "{}", study_text(cell, study));
  if (csv) {
    write_error_table(*csv, cell, study, VOLTLAP_VERSION);
    csv->complete();
  }
  if (json) {
    json->write(validation_json(cell, study, VOLTLAP_VERSION));
    json->complete();
  }
  if (csv) csv->commit();
  if (json) json->commit();
  return kExitOk;
}

}  // namespace voltlap::plant
