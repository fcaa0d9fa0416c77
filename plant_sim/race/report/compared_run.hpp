// SPDX-License-Identifier: Apache-2.0
// A run as `endurance --json` wrote it, read back for a comparison.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace voltlap::plant {

struct ComparedLap {
  int lap;
  double time_s, energy_kwh, end_soc_pct;
};

struct ComparedRun {
  std::string file;  ///< as it was named
  bool finished = false;
  double failure_time_s = 0.0;
  std::string failure_cause{};
  std::string vehicle{}, course{}, lap_start{}, cells{}, version{};
  std::uint64_t seed = 0;
  int laps_asked = 0, laps = 0;
  std::optional<double> course_length_m{};  ///< none for a recorded drive
  std::vector<std::pair<std::string, std::string>> parameters{};  ///< key and value, in the order of the file
  std::vector<double> results{};                                  ///< see compared_results()
  std::vector<std::pair<std::string, double>> limit_active_s{};
  std::vector<ComparedLap> lap_rows{};
  std::vector<std::vector<double>> trace{};  ///< by channel, see trace_channels(); lateral NaN without a course
};

/// A number of the result that a comparison shows.
struct ComparedResult {
  const char *key;   ///< in the JSON
  const char *name, *unit;
  int digits;
};
[[nodiscard]] const std::vector<ComparedResult>& compared_results();

/// Throws InputError with file and field for what is no run's JSON, or one without what a comparison needs: then with
/// the command that makes it again.
[[nodiscard]] ComparedRun read_compared_run(const std::string& file);

}  // namespace voltlap::plant
