// SPDX-License-Identifier: Apache-2.0
// Two measurements beside each other: which rows have really become slower.
#pragma once
#include <string>
#include <vector>

#include "result_file.hpp"

namespace voltlap::benchmarks {

/// A change counts when the whole interval of the ratio lies beyond this factor. Builds of the same sources differ by
/// less.
inline constexpr double kThreshold = 1.15;

enum class Verdict { kAsBefore, kSlower, kFaster, kNew, kNotMeasured };

struct ComparedRow {
  std::string name;
  double earlier_ns = 0.0, now_ns = 0.0;
  double ratio = 0.0;            ///< now / earlier, in units of the reference kernel of each run
  double low = 0.0, high = 0.0;  ///< of the ratio: both intervals taken at their far ends
  Verdict verdict = Verdict::kAsBefore;
};

[[nodiscard]] std::vector<ComparedRow> compare(const Measurement& earlier, const Measurement& now);
[[nodiscard]] bool any_slower(const std::vector<ComparedRow>& rows);
/// The table, the threshold, and what differs between the two machines or builds.
[[nodiscard]] std::string comparison_text(const Measurement& earlier, const Measurement& now,
                                          const std::vector<ComparedRow>& rows);

}  // namespace voltlap::benchmarks
