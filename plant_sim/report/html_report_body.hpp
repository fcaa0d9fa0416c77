// SPDX-License-Identifier: Apache-2.0
// The part of the endurance report that needs no script: sentence, key numbers, tables. html/endurance.html holds
// its order and the places for the charts.
#pragma once
#include <string>

#include "report/html_report.hpp"

namespace voltlap::plant {

[[nodiscard]] std::string html_report_body(const ReportedRun& reported);

}  // namespace voltlap::plant
