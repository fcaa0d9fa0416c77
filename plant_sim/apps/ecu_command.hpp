// SPDX-License-Identifier: Apache-2.0
// voltlap ecu: the firmware as a process on a CAN interface.
#pragma once
#include <string>

#include "apps/bus_options.hpp"
#include "apps/car_options.hpp"

namespace voltlap::plant {

class EcuCommand {
 public:
  explicit EcuCommand(CLI::App& app);
  /// Runs it and returns the exit code.
  int run(const DataFolder& data);
  [[nodiscard]] bool chosen() const { return command_->parsed(); }

 private:
  CLI::App* command_;
  CarOptions car_;
  BusOptions bus_;
  std::string which_;
};

}  // namespace voltlap::plant
