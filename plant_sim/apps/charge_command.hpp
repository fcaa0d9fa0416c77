// SPDX-License-Identifier: Apache-2.0
// `voltlap charge`: a car on a charger, with the firmware in the loop.
#pragma once
#include <CLI/CLI.hpp>
#include <string>

#include "apps/car_options.hpp"
#include "charge/charge_files.hpp"
#include "charge/charge_run.hpp"
#include "charge/drawn_cells.hpp"

namespace voltlap::plant {

class ChargeCommand {
 public:
  explicit ChargeCommand(CLI::App& app);
  [[nodiscard]] bool chosen() const { return command_->parsed(); }
  int run(const DataFolder& data);

 private:
  [[nodiscard]] ChargeOptions options(const DataFolder& data);

  CLI::App* command_;
  CarOptions car_;
  double from_pct_ = 10.0, to_pct_ = 100.0;
  double soc_spread_pct_ = 1.0, capacity_spread_pct_ = 1.0, resistance_spread_pct_ = 5.0;
  std::uint64_t seed_ = 1;
  bool drawn_ = false;
  std::string json_, csv_, candump_, report_;
};

}  // namespace voltlap::plant
