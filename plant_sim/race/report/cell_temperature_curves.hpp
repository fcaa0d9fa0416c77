// SPDX-License-Identifier: Apache-2.0
// Temperature of each cell over a run, for a chart that draws them all. Cells warm over minutes, so a few samples a
// lap show all there is to see, and a page of 144 cells stays as small as one of 24.
#pragma once
#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "io/page/html_series.hpp"

namespace voltlap::plant {

class CellTemperatureCurves {
 public:
  static constexpr std::size_t kValuesMax = 120'000;  ///< of all cells together; about a byte and a half each
  static constexpr std::size_t kSamplesMax = 2'000;   ///< of one cell; beyond either every 2nd, 4th ... is kept

  /// At the time series' steps; always as many cells.
  void add(double time_s, const std::vector<double>& temperature_c);

  /// {first_s, period_s, samples, columns: [{resolution, deltas}, ...]}, a column a cell.
  [[nodiscard]] nlohmann::ordered_json json() const;

 private:
  std::vector<HtmlSeries> cells_;
  double first_s_ = 0.0;
  std::size_t every_ = 1, count_ = 0;
};

}  // namespace voltlap::plant
