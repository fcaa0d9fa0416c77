// SPDX-License-Identifier: Apache-2.0
// voltlap log record: the frames of a run on a CAN interface as a candump file; in lockstep a member that loses none.
#pragma once
#include <string>

#include "apps/bus_options.hpp"
#include "core/parameter_file.hpp"

namespace voltlap::plant {

class LogRecordCommand {
 public:
  explicit LogRecordCommand(CLI::App& app);
  /// Runs it and returns the exit code.
  int run(const DataFolder& data);
  [[nodiscard]] bool chosen() const { return command_->parsed(); }

 private:
  [[nodiscard]] int log_in_lockstep() const;
  [[nodiscard]] int log_in_real_time() const;

  CLI::App* command_;
  BusOptions bus_;
  std::string file_;
};

}  // namespace voltlap::plant
