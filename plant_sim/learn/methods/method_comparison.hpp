// SPDX-License-Identifier: Apache-2.0
// The five methods and the full fit on the same recordings, beside the numbers that the reference study printed for
// its own cells.
#pragma once
#include <string>
#include <vector>

#include "learn/identify/cell_identification.hpp"

namespace voltlap::plant {

/// What a method did with all recordings together.
struct MethodScore {
  std::string name;  ///< ipo .. ffo, or "full" for the full fit from its own start
  std::size_t tests = 0, sections = 0;
  double mean_v2 = 0.0, median_v2 = 0.0, snr = 0.0;         ///< over sections: pulses, layers, or whole tests
  double whole_mean_v2 = 0.0, whole_median_v2 = 0.0;        ///< over whole tests, by the model as it is written
  double noise_floor_v2 = 0.0, seconds = 0.0;               ///< of the instrument; a test
};
[[nodiscard]] MethodScore method_score(const std::string& name, const std::vector<CellIdentification>& cells);

/// A row of the reference study, 2016, Table 6.8, with the times of its Table 6.1.
struct StudyScore {
  const char* name;
  double mean_v2, median_v2, snr, minutes;  ///< minutes a cell; 0: not printed
};
/// Null for a name that the study does not have.
[[nodiscard]] const StudyScore* study_score(const std::string& name);

/// A mean square in mV2, as people read it: "190".
[[nodiscard]] std::string square_millivolts(double square_v2);
[[nodiscard]] std::string comparison_text(const std::vector<MethodScore>& scores);
/// The text of an identification's JSON with the scores in it, as `methods`.
[[nodiscard]] std::string with_methods(const std::string& identification, const std::vector<MethodScore>& scores);

}  // namespace voltlap::plant
