// SPDX-License-Identifier: Apache-2.0
// voltlap plant: the car, its sensors and its driver as a process on a CAN interface.
#pragma once
#include <string>
#include <vector>

#include "apps/endurance_command.hpp"
#include "can_dbc/lockstep.hpp"

namespace voltlap::plant {

class PlantCommand {
 public:
  explicit PlantCommand(CLI::App& app);
  /// Runs it and returns the exit code.
  int run(const DataFolder& data);
  [[nodiscard]] bool chosen() const { return command_->parsed(); }

 private:
  [[nodiscard]] std::vector<can::Member> members() const;

  CLI::App* command_;
  EnduranceRun run_;
  BusOptions bus_;
  std::vector<std::string> members_ = {"bms", "master"};
  std::string driver_ = "auto";
  std::optional<double> duration_s_;
  double ready_within_s_ = 10.0;
  bool keep_going_ = false;
};

}  // namespace voltlap::plant
