// SPDX-License-Identifier: Apache-2.0
// What coarse steps of a thermistor say: exactly where it was when the reading changed, and little in between.
#pragma once
#include <string>
#include <vector>

#include "explain/balances/recording.hpp"

namespace voltlap::explain {

inline constexpr double kCoarse_k = 0.35;  ///< smaller steps hide less than is worth a word

/// Smallest change from one reading to the next; infinite where none changes.
[[nodiscard]] double least_change(const Eigen::VectorXd& values);
/// Is it read in coarse steps [K]? What never changes does not say.
[[nodiscard]] inline bool is_coarse(const Eigen::VectorXd& values) {
  const double step = least_change(values);
  return step > kCoarse_k && step < 1e300;
}

/// The recording with the readings of coarse thermistors straight from one change to the next; missing where the
/// reading came back to where it was, and before the first change and after the last. A thermistor that changes
/// too seldom stays as it is. `passed_s` says when the changes were: in between a model has to be straight as well
/// before it is held against them (Reader).
/// A thermistor with noise goes to and fro about a change: there it is at the middle where, over the window of
/// half a minute, it is above as often as below. `kWhole`: a pass near the recording's begin or end is none.
enum class Passes { kWhole, kAny };
[[nodiscard]] plant::Recording unstepped(plant::Recording log, Passes passes = Passes::kWhole);

/// Of an unstepped recording: was this thermistor read in coarse steps, whether they could be taken away or not?
[[nodiscard]] bool was_read_in_steps(const plant::Recording& log, const std::string& role);

/// RMS of what the steps of sensors hide, of the finest of these.
[[nodiscard]] double step_error(const plant::Recording& log, const std::vector<std::string>& roles);
/// The same of thermistors [K]. One that never changes does not tell its step: a kelvin is the coarsest that is usual.
[[nodiscard]] double step_error_of_heat(const plant::Recording& read);

}  // namespace voltlap::explain
