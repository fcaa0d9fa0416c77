// SPDX-License-Identifier: Apache-2.0
// `voltlap validate`: a cell file against recordings of that cell.
#pragma once
#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "core/parameter_file.hpp"

namespace voltlap::plant {

class ValidateCommand {
 public:
  explicit ValidateCommand(CLI::App& app);
  [[nodiscard]] bool chosen() const { return command_->parsed(); }
  int run(const DataFolder& data);

 private:
  CLI::App* command_;
  std::string cell_, map_, json_;
  std::vector<std::string> files_;
  double temperature_c_ = 25.0;
  int series_ = 1, parallel_ = 1;
};

}  // namespace voltlap::plant
