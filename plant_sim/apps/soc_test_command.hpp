// SPDX-License-Identifier: Apache-2.0
// voltlap soc-test: how far the BMS's state of charge is from the truth when it is told something wrong.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "apps/car_options.hpp"
#include "apps/progress_line.hpp"
#include "apps/recording_options.hpp"
#include "apps/soc_test_report.hpp"

namespace voltlap::plant {

class SocTestCommand {
 public:
  explicit SocTestCommand(CLI::App& app);
  int run(const DataFolder& data);
  [[nodiscard]] bool chosen() const { return command_->parsed(); }

 private:
  [[nodiscard]] std::vector<SocDriveResult> drive_all(const DataFolder& data, ProgressLine& progress) const;
  [[nodiscard]] std::vector<SocRecordingResult> read_all(const DataFolder& data, ProgressLine& progress) const;

  CLI::App* command_;
  CarOptions car_;
  std::string cell_, json_;
  RecordingOptions recordings_;
  std::optional<double> temperature_c_;  // of recordings without a thermometer
  bool short_ = false, only_recordings_ = false;
};

}  // namespace voltlap::plant
