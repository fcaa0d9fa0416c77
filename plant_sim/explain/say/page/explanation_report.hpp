// SPDX-License-Identifier: Apache-2.0
// The report of an explanation as one HTML file: the sentence first, then the residual map before and after, causes
// and runner-ups, what would tell, the gain, the race that follows. html/explain.js draws the charts.
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "explain/explanation.hpp"
#include "explain/extend/race_change.hpp"

namespace voltlap::plant {

struct ReportedExplanation {
  const Explanation& explanation;
  const RaceChange* race;                                ///< none: no race was driven
  std::vector<std::pair<std::string, std::string>> run;  ///< name and value of what it takes to repeat it
  std::string version;
};

[[nodiscard]] std::string explanation_report(const ReportedExplanation& reported);

}  // namespace voltlap::plant
