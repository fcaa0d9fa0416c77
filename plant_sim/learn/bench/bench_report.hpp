// SPDX-License-Identifier: Apache-2.0
// A campaign as one HTML file: duration against forecast, what is excited, every test over time with the ends of its
// rests, and the plan. Of a dry run the curves are the rehearsal's. html/bench.js draws the charts.
#pragma once
#include <array>
#include <string>
#include <vector>

#include "io/page/html_buckets.hpp"
#include "learn/bench/campaign_files.hpp"

namespace voltlap::plant {

class BenchReport {
 public:
  /// Opens the file; throws OutputError when it cannot be written.
  BenchReport(const std::string& path, const Campaign& campaign) : file_(path), campaign_(campaign) {}

  /// The curves of a test: points that keep every extreme, about 2500 a test of four cells.
  void add(const BenchRecord& record);
  /// Writes the whole page, not yet under its name. Without results it is a rehearsal's.
  void finish(const Forecast& forecast, const std::vector<TestResult>& results,
              const std::vector<std::string>& settings);
  void commit() { file_.commit(); }

 private:
  struct Curves {
    std::string name;
    double end_s;
    std::size_t cells;
    std::vector<HtmlSeries> columns;
    std::vector<std::array<double, 4>> rests;  ///< end [s], SOC, length [s], rise at the end [V/min]
  };

  AtomicFile file_;
  const Campaign& campaign_;
  std::vector<Curves> curves_;
};

/// How fast the fastest cell still rises at the end of a rest [V/min]: the mean of the last minute's readings less
/// that of the minute before, as the plan's own rule judges.
[[nodiscard]] double rise_at_end(const BenchRecord& record, const BenchPhase& rest);

/// The files of html/ beside this one.
[[nodiscard]] std::string_view bench_page_files(std::string_view name);

}  // namespace voltlap::plant
