// SPDX-License-Identifier: Apache-2.0
// voltlap rig: car, sensors, driver and firmware in one process, driven by a harness over two pipes; the firmware on
// emulated boards where that is asked for.
#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "apps/car_options.hpp"
#include "apps/ecu_options.hpp"
#include "io/bus/harness_bus.hpp"
#include "race/endurance.hpp"

namespace voltlap::plant {

class RigCommand {
 public:
  explicit RigCommand(CLI::App& app);
  /// Runs it and returns the exit code.
  int run(const DataFolder& data);
  [[nodiscard]] bool chosen() const { return command_->parsed(); }

 private:
  int drive(const EnduranceOptions& options, SuppliedEcus& ecus) const;

  CLI::App* command_;
  CarOptions car_;
  std::string driver_ = "none";
  std::optional<int> laps_;
  std::uint64_t seed_ = 1;
  EcuOptions ecu_;
  std::string json_;
};

}  // namespace voltlap::plant
