// SPDX-License-Identifier: Apache-2.0
// An identification as one HTML file: how the model follows the recordings, where the data excited it, every
// parameter with its interval, and the choices and repairs on the way. html/cell.js draws the charts.
#pragma once
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/parameters.hpp"
#include "learn/identify/mean_cell.hpp"
#include "learn/identify/result/cell_body.hpp"
#include "learn/methods/method_comparison.hpp"

namespace voltlap::plant {

struct ReportedCell {
  const CellParameters& cell;
  const CellBody& body;
  const CellIdentification& identified;  ///< of one cell, or the mean of several
  const std::vector<CellIdentification>& each;  ///< of each cell, with its logs
  std::string json;                             ///< identification_json of it
  const MeanCell* mean;    ///< null for one cell
  std::vector<MethodScore> scores;
  std::vector<std::pair<std::string, std::string>> run;  ///< flags and their values
};

[[nodiscard]] std::string identification_report(const ReportedCell& reported, const std::string& version);

/// Its texts and tables.
[[nodiscard]] std::string identification_report_body(const ReportedCell& reported, const std::string& version);

/// The files of html/ beside this one.
[[nodiscard]] std::string_view cell_page_files(std::string_view name);

}  // namespace voltlap::plant
