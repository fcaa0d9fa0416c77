// SPDX-License-Identifier: Apache-2.0
// What a campaign will take and show, from its rehearsal: printed before a run, and all that --dry-run prints.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "learn/bench/campaign.hpp"
#include "learn/bench/coverage.hpp"

namespace voltlap::plant {

struct TestForecast {
  BenchTest test;
  double duration_s = 0.0, charge_ah = 0.0;
  double lowest_v = 0.0, coldest_c = 0.0, hottest_c = 0.0;  ///< of the nominal cell
  double current_min_a = 0.0, current_max_a = 0.0;          ///< of the discharge
  std::size_t pulses = 0, rests = 0;
  TestEnd end = TestEnd::kProgram;
};

struct Forecast {
  std::vector<TestForecast> tests;
  Coverage coverage;
  RestSummary rests;
  double row_s = 0.0;       ///< between rows of the table
  double bench_s = 0.0;     ///< sum of the tests
  double calendar_s = 0.0;  ///< with the pauses between them
  bool interrupted = false;
};

/// How far durations of a run may lie from the forecast: its cells differ, its instruments are noisy.
inline constexpr double kForecastMargin = 0.15;

/// What a record amounts to, for a rehearsal as for a run.
[[nodiscard]] TestForecast summary_of(const BenchRecord& record);

/// `stop(test, time_s)` is asked about once a simulated minute.
[[nodiscard]] Forecast forecast(const Campaign& campaign,
                                const std::function<bool(std::size_t, double)>& stop = {});

/// For a person: tests, durations, the map of load by SOC, temperature and current, what rests can show.
[[nodiscard]] std::string forecast_text(const Campaign& campaign, const Forecast& forecast);

/// "3:05 h"
[[nodiscard]] std::string hours_text(double seconds);
[[nodiscard]] const char* end_name(TestEnd end);

}  // namespace voltlap::plant
