// SPDX-License-Identifier: Apache-2.0
#include "io/logs/row_clock.hpp"

#include <algorithm>
#include <utility>

#include "core/demand.hpp"
#include "core/signal.hpp"

namespace voltlap::plant {
namespace {

/// Stamps coarser than the rows: most rows have the stamp of the one before. They are spread evenly up to the next
/// stamp; the first and the last run, which may be cut, by the usual number of rows. Returns rows to a stamp; 0: no
/// such stamps.
double spread_runs(std::vector<double>& time_s) {
  struct Run {
    std::size_t begin, end;
  };
  std::vector<Run> runs;
  for (std::size_t k = 0; k < time_s.size(); ++k) {
    if (k == 0 || time_s[k] > time_s[k - 1]) runs.push_back({k, k});
    runs.back().end = k + 1;
  }
  constexpr std::size_t kFewestRuns = 4;
  if (runs.size() < kFewestRuns || 2 * runs.size() > time_s.size()) return 0.0;
  std::vector<double> counts, steps;
  for (std::size_t j = 1; j + 1 < runs.size(); ++j) {
    counts.push_back(static_cast<double>(runs[j].end - runs[j].begin));
    steps.push_back(time_s[runs[j + 1].begin] - time_s[runs[j].begin]);
  }
  const double usual = median(counts), step_s = median(steps);
  std::vector<double> spread = time_s;
  for (std::size_t j = 0; j < runs.size(); ++j) {
    const bool cut = j == 0 || j + 1 == runs.size();
    const double count = cut ? std::max(usual, static_cast<double>(runs[j].end - runs[j].begin))
                             : static_cast<double>(runs[j].end - runs[j].begin);
    const double length_s =
        cut ? step_s : std::min(step_s, time_s[runs[j + 1].begin] - time_s[runs[j].begin]);
    const double from = j == 0 ? count - static_cast<double>(runs[j].end) : 0.0;
    for (std::size_t k = runs[j].begin; k < runs[j].end; ++k) {
      spread[k] += length_s * (from + static_cast<double>(k - runs[j].begin)) / count;
    }
  }
  time_s = std::move(spread);
  return usual;
}

}  // namespace

void RowClock::spread() { rows_to_a_stamp = spread_runs(time_s); }

RowClock row_clock(const std::vector<double>& stamps_s) {
  RowClock out;
  CanDefects defects;
  FrameClock clock(defects, 0.0);
  RecordedFrame given;
  const auto take = [&] {
    while (clock.pop(given)) {
      out.row.push_back(given.line - 1);
      out.time_s.push_back(given.time_s);
    }
  };
  for (std::size_t row = 0; row < stamps_s.size(); ++row) {
    clock.slot().time_s = stamps_s[row];
    clock.slot().line = row + 1;
    clock.push();
    take();
  }
  clock.finish();
  take();
  out.defects = defects.all();
  out.parts = clock.parts();
  VOLTLAP_DEMAND(out.row.size() == out.time_s.size() && out.row.size() <= stamps_s.size());
  return out;
}

}  // namespace voltlap::plant
