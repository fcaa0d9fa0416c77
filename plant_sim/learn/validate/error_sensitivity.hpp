// SPDX-License-Identifier: Apache-2.0
// RMS error with each parameter 1 and 5 % off (reference study, 2016, section 7.4, Table 7.3). Capacitances are
// free, as there: R with its C held changes tau with it. Every recording with its own best capacity, as there.
#pragma once
#include <array>
#include <string>
#include <vector>

#include "learn/validate/prediction_error.hpp"

namespace voltlap::plant {

/// Relative changes, in the order of the study's columns.
inline constexpr std::array kSensitivitySteps{0.05, 0.01, 0.0, -0.01, -0.05};

struct ErrorSensitivity {
  std::string parameter;  ///< em, r0, r and c of each branch, initial_soc, capacity
  std::array<double, kSensitivitySteps.size()> rms_v{};
};

/// Over all recordings together.
[[nodiscard]] std::vector<ErrorSensitivity> error_sensitivities(const CellParameters& cell,
                                                                const std::vector<PlacedRecording>& recordings,
                                                                const std::vector<CapacityAdjustment>& capacities);

}  // namespace voltlap::plant
