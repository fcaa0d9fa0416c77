// SPDX-License-Identifier: Apache-2.0
// voltlap lap: the lap solver alone, without battery and firmware.
#pragma once
#include <string>

#include "apps/car_options.hpp"

namespace voltlap::plant {

class LapCommand {
 public:
  explicit LapCommand(CLI::App& app);
  int run(const DataFolder& data);
  [[nodiscard]] bool chosen() const { return command_->parsed(); }

 private:
  CLI::App* command_;
  CarOptions car_;
  std::string json_;
};

}  // namespace voltlap::plant
