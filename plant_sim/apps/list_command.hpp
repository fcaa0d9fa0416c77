// SPDX-License-Identifier: Apache-2.0
// voltlap list: names that the other commands take, the keys of --set, the causes that explain knows.
#pragma once
#include <string>

#include "apps/car_options.hpp"

namespace voltlap::plant {

class ListCommand {
 public:
  explicit ListCommand(CLI::App& app);
  int run(const DataFolder& data);
  [[nodiscard]] bool chosen() const { return command_->parsed(); }

 private:
  CLI::App* command_;
  std::string what_;
  CarOptions car_;
};

}  // namespace voltlap::plant
