// SPDX-License-Identifier: Apache-2.0
// What soc-test has measured, beside its marks: a table and JSON.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "apps/soc_recording.hpp"

namespace voltlap::plant {

/// RMS and largest error that are asked for, in points.
struct SocMark {
  double rms, largest;
};
inline constexpr SocMark kMarkOne{1.5, 3.0}, kMarkTogether{2.0, 5.0};

struct SocJudgedCase {
  SocCase told;
  SocMark mark;
};

struct SocDriveResult {
  std::string course, car;  ///< the car: what is different in the plant
  std::vector<SocMark> marks;
  SocTrialResult trial;
};

[[nodiscard]] bool met(const SocScore& score, const SocMark& mark);
/// Of a recording: together's, or what the slope of its OCV allows; none where that is more than a quarter of the
/// charge.
[[nodiscard]] std::optional<SocMark> mark_of(const SocRecordingResult& recording);

[[nodiscard]] std::string soc_test_text(const std::vector<SocDriveResult>& drives,
                                        const std::vector<SocRecordingResult>& recordings);
[[nodiscard]] std::string soc_test_json(const std::vector<SocDriveResult>& drives,
                                        const std::vector<SocRecordingResult>& recordings);

}  // namespace voltlap::plant
