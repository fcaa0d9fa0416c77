// SPDX-License-Identifier: Apache-2.0
// `voltlap validate`: a cell file against recordings of that cell.
#pragma once
#include <CLI/CLI.hpp>
#include <string>

#include "apps/progress_line.hpp"
#include "apps/recording_options.hpp"
#include "core/parameter_file.hpp"
#include "learn/validate/validation_study.hpp"

namespace voltlap::plant {

class ValidateCommand {
 public:
  explicit ValidateCommand(CLI::App& app);
  [[nodiscard]] bool chosen() const { return command_->parsed(); }
  int run(const DataFolder& data);

 private:
  [[nodiscard]] std::vector<CellLog> read(const DataFolder& data, ProgressLine& progress) const;
  [[nodiscard]] StudyOptions options(const std::vector<CellLog>& logs, ProgressLine& progress) const;
  /// Of other numbers of cells, where a recording is missed by far.
  /// Of each log what it is told, empty where nothing.
  std::vector<std::string> add_hints(const CellParameters& cell, const std::vector<CellLog>& logs,
                                     ValidationStudy& study) const;
  [[nodiscard]] std::string command_line() const;

  CLI::App* command_;
  RecordingOptions recordings_;
  std::string cell_, json_, csv_, report_;
  StudyOptions study_;
  bool full_ = false;
};

}  // namespace voltlap::plant
