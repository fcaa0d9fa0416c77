// SPDX-License-Identifier: Apache-2.0
// voltlap log convert: the frames of a recording in another format.
#pragma once
#include <string>

#include "apps/recording_input.hpp"

namespace voltlap::plant {

class LogConvertCommand {
 public:
  explicit LogConvertCommand(CLI::App& app);
  /// Throws InputError and OutputError.
  int run(const DataFolder& data);
  [[nodiscard]] bool chosen() const { return command_->parsed(); }

 private:
  CLI::App* command_;
  RecordingInput recording_;
  std::string out_, bus_;
  double from_s_ = 0.0, to_s_ = 1e300;
};

}  // namespace voltlap::plant
