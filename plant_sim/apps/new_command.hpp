// SPDX-License-Identifier: Apache-2.0
// voltlap new car: a team's own car as one commented file, and what follows from its numbers.
#pragma once
#include <optional>
#include <string>

#include "apps/car_sheet.hpp"
#include "core/parameter_file.hpp"

#include <CLI/CLI.hpp>

namespace voltlap::plant {

class NewCommand {
 public:
  explicit NewCommand(CLI::App& app);
  int run(const DataFolder& data);
  [[nodiscard]] bool chosen() const { return command_->parsed(); }

 private:
  [[nodiscard]] CarRequest request() const;
  [[nodiscard]] std::string file() const;

  CLI::App* command_;
  CLI::App* car_;
  CarRequest request_;
  std::string name_, cells_, cell_, motor_;
  std::optional<double> gear_, tyre_radius_m_, driver_kg_;
  bool force_ = false;
};

}  // namespace voltlap::plant
