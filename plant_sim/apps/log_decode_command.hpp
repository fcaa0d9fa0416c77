// SPDX-License-Identifier: Apache-2.0
// voltlap log decode: signals of a recording as CSV, Parquet, MF4 or MCAP.
#pragma once
#include <string>
#include <vector>

#include "apps/recording_input.hpp"

namespace voltlap::plant {

class LogDecodeCommand {
 public:
  explicit LogDecodeCommand(CLI::App& app);
  /// Throws InputError and OutputError.
  int run(const DataFolder& data);
  [[nodiscard]] bool chosen() const { return command_->parsed(); }

 private:
  CLI::App* command_;
  RecordingInput recording_;
  std::string out_;
  std::vector<std::string> signals_;
  double every_s_ = 0.0;
};

}  // namespace voltlap::plant
