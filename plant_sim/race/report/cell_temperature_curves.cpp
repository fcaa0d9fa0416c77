// SPDX-License-Identifier: Apache-2.0
#include "race/report/cell_temperature_curves.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/demand.hpp"
#include "race/report/time_series_file.hpp"

namespace voltlap::plant {

void CellTemperatureCurves::add(double time_s, const std::vector<double>& temperature_c) {
  constexpr double kResolution_k = 0.02;
  VOLTLAP_DEMAND(!temperature_c.empty());
  if (count_ == 0) {
    first_s_ = time_s;
    cells_.assign(temperature_c.size(), HtmlSeries("", kResolution_k));
  }
  VOLTLAP_DEMAND(temperature_c.size() == cells_.size());
  if (count_++ % every_ != 0) return;
  for (std::size_t cell = 0; cell < cells_.size(); ++cell) cells_[cell].add(temperature_c[cell]);
  if (cells_[0].size() <= std::min(kSamplesMax, kValuesMax / cells_.size())) return;
  for (HtmlSeries& cell : cells_) cell.halve();
  every_ *= 2;
}

nlohmann::ordered_json CellTemperatureCurves::json() const {
  nlohmann::ordered_json columns = nlohmann::ordered_json::array();
  for (const HtmlSeries& cell : cells_)
    columns.push_back({{"resolution", cell.resolution()}, {"deltas", cell.base64()}});
  return {{"first_s", first_s_},
          {"period_s", static_cast<double>(every_) / TimeSeriesFile::kSamplesPerSecond},
          {"samples", cells_.empty() ? 0 : cells_[0].size()},
          {"columns", columns}};
}

}  // namespace voltlap::plant
