// SPDX-License-Identifier: Apache-2.0
// voltlap list causes: the causes that explain knows, with what is believed of them beforehand.
#pragma once
#include <string>

#include "apps/car_options.hpp"

namespace voltlap::plant {

class ListCausesCommand {
 public:
  explicit ListCausesCommand(CLI::App& app);
  int run(const DataFolder& data);
  [[nodiscard]] bool chosen() const { return command_->parsed(); }

 private:
  CLI::App* command_;
  std::string what_;
  CarOptions car_;
};

}  // namespace voltlap::plant
