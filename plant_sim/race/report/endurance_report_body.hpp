// SPDX-License-Identifier: Apache-2.0
// The part of the endurance report that needs no script: sentence, key numbers, tables. html/endurance.html holds
// its order and the places for the charts.
#pragma once
#include <string>

#include "race/report/endurance_report.hpp"

namespace voltlap::plant {

[[nodiscard]] std::string html_report_body(const ReportedRun& reported);

/// The files of html/ beside this one.
[[nodiscard]] std::string_view endurance_page_files(std::string_view name);

}  // namespace voltlap::plant
