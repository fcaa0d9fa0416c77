// SPDX-License-Identifier: Apache-2.0
// voltlap limit-test: what the BMS's current limits promise, against what the plant does.
#pragma once
#include <cstdint>
#include <string>

#include "apps/car_options.hpp"
#include "apps/limit_test_report.hpp"
#include "apps/progress_line.hpp"

namespace voltlap::plant {

class LimitTestCommand {
 public:
  explicit LimitTestCommand(CLI::App& app);
  int run(const DataFolder& data);
  [[nodiscard]] bool chosen() const { return command_->parsed(); }

 private:
  void ask_states(const DataFolder& data, ProgressLine& progress, LimitTestResult& out) const;
  void drive_races(const DataFolder& data, ProgressLine& progress, LimitTestResult& out) const;
  [[nodiscard]] EnduranceOptions drive_of(const DataFolder& data, const std::string& track,
                                          const std::vector<std::string>& settings) const;

  CLI::App* command_;
  CarOptions car_;
  std::string json_, only_;
  int states_ = 2000;
  std::uint64_t seed_ = 1;
};

}  // namespace voltlap::plant
