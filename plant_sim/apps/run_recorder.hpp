// SPDX-License-Identifier: Apache-2.0
// Watches an endurance: hashes and files of its frames, its time series, the progress line, Ctrl-C.
#pragma once
#include <chrono>
#include <optional>
#include <string>

#include "io/bus/bus_load.hpp"
#include "io/bus/candump_file.hpp"
#include "io/bus/trace_hash.hpp"
#include "race/endurance.hpp"
#include "race/report/distance_trace.hpp"
#include "race/report/endurance_report.hpp"
#include "race/report/time_series_file.hpp"

namespace voltlap::plant {

/// From here on Ctrl-C, a request to terminate and a closed terminal ask the run to stop instead of ending the process.
void catch_interrupt();
/// What the process ends with after that.
[[nodiscard]] int exit_code_of_interrupt();
[[nodiscard]] bool interrupted();

class RunRecorder : public EnduranceObserver {
 public:
  std::optional<TimeSeriesFile> series;
  std::optional<CandumpFile> candump;
  std::optional<BusLoad> load;
  std::optional<HtmlReport> report;
  DistanceTrace trace;
  TraceHash hash;

  void on_frame(std::uint32_t tick, Sender sender, const Frame& frame) override;
  void on_sample(const TimeSample& sample) override;
  void on_progress(double fraction, double time_s) override;
  [[nodiscard]] bool stop_requested() override;

  /// Clears the progress line.
  void end_progress();
  /// Everything that was recorded is on the disk; then `commit` puts the files in place.
  void complete();
  void commit();

 private:
  std::chrono::steady_clock::time_point shown_ = std::chrono::steady_clock::now();
  bool line_open_ = false;
};

}  // namespace voltlap::plant
