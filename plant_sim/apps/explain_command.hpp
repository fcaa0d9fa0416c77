// SPDX-License-Identifier: Apache-2.0
// voltlap explain: what a simulation gets wrong about a log, by name and size.
#pragma once
#include <CLI/CLI.hpp>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "apps/map_finding.hpp"
#include "apps/progress_line.hpp"
#include "core/parameter_file.hpp"
#include "explain/explain.hpp"
#include "explain/extend/race_change.hpp"

namespace voltlap::plant {

class ExplainCommand {
 public:
  explicit ExplainCommand(CLI::App& app);
  [[nodiscard]] bool chosen() const { return command_->parsed(); }
  int run(const DataFolder& data);

 private:
  /// With --dbc or --write-map: makes the log's map and sees to it that --map names its file.
  [[nodiscard]] std::unique_ptr<ScratchFile> find_map();
  void refuse_shared_files() const;
  /// Splits --set into settings of the model and of the explanation itself.
  [[nodiscard]] std::vector<std::string> take_settings(explain::ExplainOptions& options);
  [[nodiscard]] Explanation explained(const DataFolder& data, Model& model,
                                      const explain::ExplainOptions& options) const;
  /// What the explanation changes in the endurance, when a report is asked for.
  [[nodiscard]] std::optional<RaceChange> raced(const DataFolder& data, const Model& model,
                                                const Explanation& explanation, ProgressLine& line) const;
  [[nodiscard]] std::vector<std::pair<std::string, std::string>> run_facts(const Model& model) const;

  CLI::App* command_;
  std::string log_, map_, model_, holdout_, json_, report_, write_model_;
  MapFinding finding_;
  std::vector<std::string> references_, settings_;
  std::uint64_t seed_ = 1;
};

}  // namespace voltlap::plant
