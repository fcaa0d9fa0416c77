// SPDX-License-Identifier: Apache-2.0
// What is mended in a recording of a cell, each repair in words in CellLog::repairs; what cannot be mended is refused.
#pragma once
#include <cstddef>
#include <vector>

#include "io/logs/cell_log.hpp"

namespace voltlap::plant {

/// Assumed between two parts of a recording whose clock started again [s]; the state after it is left free.
inline constexpr double kJoinPause = 60.0;

/// Rows in time order: holes in time or current and repeated times are left out; a clock that starts again is joined
/// on. `time` is shifted there, `joined` says for each row that is kept whether it begins a part.
[[nodiscard]] std::vector<std::size_t> rows_in_order(std::vector<double>& time, const std::vector<double>& current,
                                                     CellLog& log, std::vector<bool>& joined);

/// Volts of one cell: unit from the size of the numbers when it is not what the map says. Throws InputError for those
/// of no cell.
void bring_to_one_cell(CellLog& log, int series);

/// Discharge positive: as declared, or as the voltage answers. Throws InputError where it contradicts what is declared.
void settle_sign(CellLog& log, DischargeSign declared);

/// A counter may count either way; it is turned to agree with the current.
void settle_counter(CellLog& log);

/// Gaps: an interval far longer than the recorder's habit, or one in which the counter saw what the rows did not.
void find_gaps(CellLog& log, const std::vector<bool>& joined);

/// A recorder that polls faster than its source repeats rows. Where the current is held on purpose that says nothing.
void note_held_rows(CellLog& log);

}  // namespace voltlap::plant
