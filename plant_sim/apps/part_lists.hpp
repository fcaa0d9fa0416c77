// SPDX-License-Identifier: Apache-2.0
// `voltlap list motors` and `voltlap list cells`: a line a file, its name first, then the numbers by which one chooses.
#pragma once
#include <string>

#include "core/parameter_file.hpp"

namespace voltlap::plant {

/// Torque, power and efficiency at their peaks, at the curve's voltage; "-" for what a file does not state.
[[nodiscard]] std::string motor_list(const DataFolder& data);

/// At half charge and 25 degC; the energy is that of the open-circuit voltage from full to empty.
[[nodiscard]] std::string cell_list(const DataFolder& data);

}  // namespace voltlap::plant
