// SPDX-License-Identifier: Apache-2.0
// A recording that a cell file misses by far may only have been read with the wrong number of cells.
#pragma once
#include <optional>
#include <string>

#include "learn/validate/prediction_error.hpp"

namespace voltlap::plant {

/// The numbers of cells that a recording was read with.
struct CellCounts {
  int in_series = 1, in_parallel = 1;
};

/// Where the RMS is above 150 mV: the other number in parallel (up to 100) or in series (within a quarter) with which
/// it falls to a quarter and below 100 mV, in a sentence that names the flag. The first 5000 rows are looked at. Empty
/// where no such number does.
[[nodiscard]] std::optional<std::string> count_hint(const CellModel& model, const CellLog& log,
                                                    const ValidationOptions& options, const CellCounts& counts,
                                                    double rms_v);

}  // namespace voltlap::plant
