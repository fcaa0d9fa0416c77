// SPDX-License-Identifier: Apache-2.0
// voltlap log plot: chosen signals of a recording over time as one HTML page.
#pragma once
#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/parameter_file.hpp"
#include "io/logs/plot/plotted_signals.hpp"

namespace voltlap::plant {

class LogPlotCommand {
 public:
  explicit LogPlotCommand(CLI::App& app);
  /// Throws InputError and OutputError.
  int run(const DataFolder& data);
  [[nodiscard]] bool chosen() const { return command_->parsed(); }

 private:
  [[nodiscard]] std::string command_line() const;

  CLI::App* command_;
  SignalSources sources_;
  std::vector<std::string> signals_;
  std::optional<double> from_s_, to_s_;
  std::string report_;
};

}  // namespace voltlap::plant
