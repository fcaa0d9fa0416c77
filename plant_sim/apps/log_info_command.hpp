// SPDX-License-Identifier: Apache-2.0
// voltlap log info and log check: what is in a recording of a CAN bus, and what is wrong with it.
#pragma once
#include <string>

#include "apps/recording_input.hpp"
#include "io/logs/can/frame_survey.hpp"

namespace voltlap::plant {

class LogInfoCommand {
 public:
  explicit LogInfoCommand(CLI::App& app);
  /// Throws InputError and OutputError.
  int run(const DataFolder& data);
  [[nodiscard]] bool chosen() const { return command_->parsed(); }

 private:
  CLI::App* command_;
  RecordingInput recording_;
  std::string json_;
  double bit_rate_kbit_s_ = 500.0;
};

class LogCheckCommand {
 public:
  explicit LogCheckCommand(CLI::App& app);
  /// kExitDefects when something is wrong with the recording. Throws InputError and OutputError.
  int run(const DataFolder& data);
  [[nodiscard]] bool chosen() const { return command_->parsed(); }

 private:
  CLI::App* command_;
  RecordingInput recording_;
  std::string json_;
};

}  // namespace voltlap::plant
