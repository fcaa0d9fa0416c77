// SPDX-License-Identifier: Apache-2.0
// The report of an endurance as one HTML file: what happened in a sentence, the key numbers, linked charts, tables,
// and all that is needed to repeat the run. The texts and tables are HTML; html/endurance.js draws the charts.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "core/parameter_file.hpp"
#include "io/atomic_file.hpp"
#include "io/page/html_series.hpp"
#include "race/report/cell_temperature_curves.hpp"
#include "race/report/run_result.hpp"

namespace voltlap::plant {

/// What there is to tell of a run beside its samples.
struct ReportedRun {
  RunDescription run;
  LoadedVehicle car;
  std::optional<Track> track;  ///< none for a recorded drive
  EnduranceResult result;
  TraceHash::Result hash;
  double wall_s;  ///< real time that the run took
  std::vector<LimitCost> limit_costs{};
};

class HtmlReport {
 public:
  static constexpr std::size_t kSamplesMax =
      40'000;  ///< more than 66 min at 10 Hz; longer runs keep every 2nd, 4th ...

  /// Opens the file; throws OutputError when it cannot be written.
  explicit HtmlReport(const std::string& path);

  void add(const TimeSample& sample);
  /// Writes the whole page, not yet under its name.
  void finish(const ReportedRun& reported);
  void commit() { file_.commit(); }

 private:
  [[nodiscard]] std::string data(const ReportedRun& reported) const;

  AtomicFile file_;
  std::vector<HtmlSeries> columns_;
  CellTemperatureCurves cells_;
  double first_s_ = 0.0;
  std::size_t every_ = 1, count_ = 0;  ///< one sample of so many is kept; samples handed over
};

}  // namespace voltlap::plant
