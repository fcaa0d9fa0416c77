// SPDX-License-Identifier: Apache-2.0
// The report of a validation as one HTML file: the errors in a sentence, recording and model over time, the tables
// of the study with the reference study's numbers beside. html/validation.js draws the charts.
#pragma once
#include <string>
#include <vector>

#include "learn/validate/study_tables.hpp"

namespace voltlap::plant {

struct ReportedValidation {
  std::string version, command;  ///< the command line that makes it again
};

/// Recordings beyond so many have their numbers and no charts: those with the largest errors are drawn.
inline constexpr std::size_t kChartedRecordings = 24;
/// Of so many rows one is drawn, the one with the largest error: a recording has at most about this many points, all of
/// them together the second number.
inline constexpr std::size_t kChartedRows = 6000, kChartedRowsOfAll = 60'000;

[[nodiscard]] std::string validation_report(const CellParameters& cell, const ValidationStudy& study,
                                            const ReportedValidation& reported);

/// The files of html/ beside this one.
[[nodiscard]] std::string_view validation_page_files(std::string_view name);

}  // namespace voltlap::plant
