// SPDX-License-Identifier: Apache-2.0
// `voltlap replay`: a recorded log through the production firmware, and what it would have done.
#pragma once
#include <CLI/CLI.hpp>
#include <cstdio>
#include <string>
#include <vector>

#include "apps/map_finding.hpp"
#include "apps/replay_outputs.hpp"
#include "core/parameter_file.hpp"
#include "replay/replay_result.hpp"

namespace voltlap::plant {

class ReplayCommand {
 public:
  explicit ReplayCommand(CLI::App& app);
  [[nodiscard]] bool chosen() const { return command_->parsed(); }
  [[nodiscard]] int run(const DataFolder& data);

 private:
  [[nodiscard]] ReplayResult of_own(const DataFolder& data) const;
  [[nodiscard]] ReplayResult by_role(const DataFolder& data) const;
  bool report_changes(const ReplayResult& result, std::FILE* to) const;

  CLI::App* command_;
  std::string log_, map_, pack_, baseline_;
  std::vector<std::string> settings_;
  MapFinding finding_;
  ReplayOutputs outputs_;
};

}  // namespace voltlap::plant
