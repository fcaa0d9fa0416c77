// SPDX-License-Identifier: Apache-2.0
// `voltlap firmware-tables`: a cell file as the header that a BMS image is built with.
#pragma once
#include <CLI/CLI.hpp>
#include <string>

#include "apps/car_options.hpp"

namespace voltlap::plant {

class FirmwareTablesCommand {
 public:
  explicit FirmwareTablesCommand(CLI::App& app);
  [[nodiscard]] bool chosen() const { return command_->parsed(); }
  int run(const DataFolder& data);

 private:
  CLI::App* command_;
  CarOptions car_;
  [[nodiscard]] std::string command_line() const;

  std::string cell_, out_, master_out_;
};

}  // namespace voltlap::plant
