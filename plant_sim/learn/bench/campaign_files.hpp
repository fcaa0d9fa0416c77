// SPDX-License-Identifier: Apache-2.0
// What a campaign leaves on disk: a plain table for each cell and test, the truth apart from it, and an index.
//
//   <folder>/<test>_cell<n>.csv[.gz]  time_s,current_a,voltage_v,temperature_c,ambient_c     (discharge positive)
//   <truth> test,time_s,current_a,cell_<n>_voltage_v,cell_<n>_soc,cell_<n>_temperature_c,... <folder>/campaign.json
//   plan, seed, version, forecast, tests with their files; truth when it was asked for
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "io/atomic_file.hpp"
#include "learn/bench/forecast.hpp"

namespace voltlap::plant {

struct CampaignPaths {
  std::string folder;  ///< created when missing; empty: no tables
  bool gzip = false;   ///< tables as .csv.gz
  std::string truth;   ///< empty: no truth, in the index neither
};

/// One test as it went, without its columns.
struct TestResult {
  TestForecast summary;
  std::size_t end_cell = 0;
  std::vector<double> capacity_ah, resistance_scale, initial_soc;  ///< truth, one a cell
  std::vector<std::string> files;                                  ///< names in the folder, one a cell
};

class CampaignFiles {
 public:
  /// Throws OutputError when the folder or the truth file cannot be written.
  CampaignFiles(const Campaign& campaign, CampaignPaths paths);

  /// Writes the tables of a test and keeps its result.
  void add(const BenchRecord& record);
  [[nodiscard]] const std::vector<TestResult>& results() const { return results_; }

  /// The index as JSON; without results it is the forecast alone.
  [[nodiscard]] std::string index(const Forecast& forecast, const std::vector<std::string>& settings) const;
  /// Puts truth and index in place.
  void commit(const std::string& index);

 private:
  void write_table(const BenchRecord& record, std::size_t cell, const std::string& name) const;
  void write_truth(const BenchRecord& record);

  const Campaign& campaign_;
  CampaignPaths paths_;
  std::optional<AtomicFile> truth_;
  std::vector<TestResult> results_;
};

}  // namespace voltlap::plant
