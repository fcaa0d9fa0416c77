// SPDX-License-Identifier: Apache-2.0
// voltlap endurance: one race of a car with its firmware on the bus.
#pragma once
#include <optional>
#include <string>

#include "apps/car_options.hpp"
#include "report/run_result.hpp"

namespace voltlap::plant {

class EnduranceCommand {
 public:
  /// Adds the command and its flags.
  explicit EnduranceCommand(CLI::App& app);
  /// Runs it and returns the exit code. Throws InputError and OutputError.
  int run(const DataFolder& data);
  [[nodiscard]] bool chosen() const { return command_->parsed(); }

 private:
  [[nodiscard]] EnduranceOptions options(const DataFolder& data) const;
  [[nodiscard]] RunDescription description(const EnduranceOptions& options) const;
  void refuse_shared_files() const;

  CLI::App* command_;
  CarOptions car_;
  std::string drive_, cells_ = "all", json_, csv_, candump_;
  std::optional<int> laps_;
  std::uint64_t seed_ = 1;
  double rate_hz_ = 10.0;
};

}  // namespace voltlap::plant
