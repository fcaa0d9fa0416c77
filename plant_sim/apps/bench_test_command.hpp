// SPDX-License-Identifier: Apache-2.0
// voltlap bench-test: the virtual battery test bench, to plan and to rehearse a test.
#pragma once
#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <string>
#include <vector>

#include "core/parameter_file.hpp"
#include "learn/bench/bench_report.hpp"

namespace voltlap::plant {

class BenchTestCommand {
 public:
  /// Adds the command and its flags.
  explicit BenchTestCommand(CLI::App& app);
  /// Runs it and returns the exit code. Throws InputError and OutputError.
  int run(const DataFolder& data);
  [[nodiscard]] bool chosen() const { return command_->parsed(); }

 private:
  [[nodiscard]] Campaign campaign(const DataFolder& data) const;
  void refuse_files_that_clash() const;
  /// `report` may be null.
  int run_tests(const Campaign& campaign, const Forecast& forecast, CampaignFiles& files, BenchReport* report);

  CLI::App* command_;
  std::string plan_, cell_ = "aesc_e5_2p", out_, truth_, json_, report_;
  std::vector<std::string> settings_;
  std::uint64_t seed_ = 1;
  std::FILE* summary_ = stdout;
  bool dry_run_ = false, gzip_ = false;
};

}  // namespace voltlap::plant
