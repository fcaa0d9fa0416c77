// SPDX-License-Identifier: Apache-2.0
// voltlap explain: what a simulation gets wrong about a log, by name and size.
#pragma once
#include <CLI/CLI.hpp>
#include <cstdint>
#include <string>
#include <vector>

#include "core/parameter_file.hpp"
#include "discrepancy/explain.hpp"

namespace voltlap::plant {

class ExplainCommand {
 public:
  explicit ExplainCommand(CLI::App& app);
  [[nodiscard]] bool chosen() const { return command_->parsed(); }
  int run(const DataFolder& data);

 private:
  /// Splits --set into settings of the model and of the explanation itself.
  [[nodiscard]] std::vector<std::string> take_settings(ExplainOptions& options) const;

  CLI::App* command_;
  std::string log_, map_, model_, json_, write_model_;
  std::vector<std::string> references_, settings_;
  std::uint64_t seed_ = 1;
};

}  // namespace voltlap::plant
