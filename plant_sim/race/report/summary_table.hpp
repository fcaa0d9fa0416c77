// SPDX-License-Identifier: Apache-2.0
// The result of an endurance as a small table for the terminal, beside the reference study's row where there is one.
#pragma once
#include <optional>
#include <string>

#include "race/report/run_result.hpp"

namespace voltlap::plant {

/// A row of plant_sim/data/reference/endurance.csv.
struct ReferenceRow {
  std::string run;
  double end_soc_pct, max_battery_temp_c, total_time_s, max_battery_current_a, min_pack_voltage_v, max_speed_mps;
};

/// The row that has the run's vehicle, course, laps, lap start and settings, if any. Throws InputError when the file
/// cannot be read.
[[nodiscard]] std::optional<ReferenceRow> find_reference(const std::string& path, const RunDescription& run);

/// Several lines, with a final newline.
[[nodiscard]] std::string summary_table(const RunDescription& run, const EnduranceResult& result,
                                        const std::optional<ReferenceRow>& reference);

/// What is worth knowing of the CAN interface, one or two lines.
[[nodiscard]] std::string bus_statistics_text(const BusStatistics& bus, double simulated_s, double wall_s);

}  // namespace voltlap::plant
