// SPDX-License-Identifier: Apache-2.0
// `voltlap replay`: a recorded log through the production firmware, and what it would have done.
#pragma once
#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "apps/map_finding.hpp"
#include "apps/replay_outputs.hpp"
#include "apps/replay_run.hpp"
#include "core/parameter_file.hpp"

namespace voltlap::plant {

class ReplayCommand {
 public:
  explicit ReplayCommand(CLI::App& app);
  [[nodiscard]] bool chosen() const { return command_->parsed(); }
  [[nodiscard]] int run(const DataFolder& data);

 private:
  [[nodiscard]] int run_folder(const DataFolder& data) const;

  CLI::App* command_;
  ReplayAsked asked_;
  ReplayOutputs outputs_;
  std::string baseline_, firmware_;
  std::vector<std::string> what_if_;
  MapFinding finding_;
};

}  // namespace voltlap::plant
