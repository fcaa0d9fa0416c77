// SPDX-License-Identifier: Apache-2.0
// What is said about a run in words, the same in the terminal and in the report.
#pragma once
#include <string>

#include "race/report/run_result.hpp"

namespace voltlap::plant {

/// "33:42 min"
[[nodiscard]] std::string duration_text(double seconds);

/// "power 12.3 s, soc_low 4.0 s"; "none" when nothing held the driver back.
/// What braking gave back, and how much farther the charge goes for it: gross over net energy.
[[nodiscard]] std::string regeneration_text(const EnduranceResult& result);

[[nodiscard]] std::string limits_text(const EnduranceResult& result);

/// Whether no cell can be weaker than another: they were simulated alike.
[[nodiscard]] bool cells_alike(const RunDescription& run, const VehicleParameters& car);

/// Whether the car got as far as being ready to drive; before that there is nothing to tell of it.
[[nodiscard]] bool was_ready_to_drive(const EnduranceResult& result);

/// One sentence or two: finished or not and why, time, charge left, hottest battery, weakest cell.
[[nodiscard]] std::string headline(const RunDescription& run, const VehicleParameters& car,
                                   const EnduranceResult& result);

}  // namespace voltlap::plant
