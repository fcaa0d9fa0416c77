// SPDX-License-Identifier: Apache-2.0
// Units that the numbers of a recording contradict. Where nobody told the unit it is found from the numbers and said;
// where a map or a column's name told it, the recording is refused rather than read in another one. Only kelvin in a
// column of degC is always converted: no recording of a battery can mean it otherwise.
#pragma once
#include <string>
#include <vector>

#include "io/logs/cell_log.hpp"

namespace voltlap::plant {

/// A time since 1970 in ms or us, days of a spreadsheet; times that are none become NaN.
void settle_clock(std::vector<double>& time, const RoleSource& source, CellLog& log);

/// Milliamperes taken for amperes: by a resistance that no cell has together with a current that none carries. Then
/// currents beyond what the role allows become NaN, each counted; more than a few in a hundred are refused.
void settle_current_unit(std::vector<double>& current, const std::vector<double>& voltage, const RoleSource& source,
                         const LogOptions& options, CellLog& log);

/// Kelvin taken for degC; readings beyond what the role allows become NaN.
void settle_temperature_unit(std::vector<double>& temperature, const std::string& role, CellLog& log);

/// Milliseconds, minutes or hours taken for seconds, mAh taken for Ah: by the recorder's own counter, else by a drop
/// over the resistance at one C that no cell survives.
void settle_time_unit(CellLog& log, const RoleMap& map);

/// Holes between readings of a slow signal are bridged straight, those at the ends held; one without readings is empty.
void fill_holes(std::vector<double>& values, const std::vector<double>& time_s, const std::string& role, CellLog& log);

}  // namespace voltlap::plant
