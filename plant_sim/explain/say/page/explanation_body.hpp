// SPDX-License-Identifier: Apache-2.0
// The part of an explanation's report that needs no script: sentence, key numbers, residual map, tables.
// html/explain.html holds its order and the places for the charts.
#pragma once
#include <string>

#include "explain/say/page/explanation_report.hpp"

namespace voltlap::plant {

[[nodiscard]] std::string explanation_body(const ReportedExplanation& reported);

/// The files of html/ beside this one.
[[nodiscard]] std::string_view explanation_page_files(std::string_view name);

}  // namespace voltlap::plant
