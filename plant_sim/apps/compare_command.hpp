// SPDX-License-Identifier: Apache-2.0
// voltlap compare: runs of endurance over each other, by lap and by distance.
#pragma once
#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "core/parameter_file.hpp"

namespace voltlap::plant {

class CompareCommand {
 public:
  explicit CompareCommand(CLI::App& app);
  /// Throws InputError and OutputError.
  int run(const DataFolder& data);
  [[nodiscard]] bool chosen() const { return command_->parsed(); }

 private:
  CLI::App* command_;
  std::vector<std::string> files_;
  std::string json_, report_;
};

}  // namespace voltlap::plant
