// SPDX-License-Identifier: Apache-2.0
// voltlap track: a team's own course becomes a course file, and what a course file is.
#pragma once
#include <string>

#include <CLI/CLI.hpp>

#include "core/parameter_file.hpp"
#include "race/track/import/course_import.hpp"

namespace voltlap::plant {

class TrackCommand {
 public:
  explicit TrackCommand(CLI::App& app);
  int run(const DataFolder& data);
  [[nodiscard]] bool chosen() const { return command_->parsed(); }

 private:
  void add_import();
  void add_show();
  [[nodiscard]] ImportOptions import_options() const;
  [[nodiscard]] std::string file_head(const ImportedCourse& course) const;
  int import() const;
  int show(const DataFolder& data) const;

  CLI::App *command_, *import_ = nullptr, *show_ = nullptr;
  std::string source_, out_, kind_, unit_, name_, plot_, json_, track_;
  double noise_m_ = -1.0;
  unsigned lap_ = 0;
  bool open_ = false, closed_ = false, reversed_ = false, mirrored_ = false;
};

}  // namespace voltlap::plant
