// SPDX-License-Identifier: Apache-2.0
// Temperatures and currents at which the recordings of a cell were made: the axes of its tables.
#pragma once
#include <cstddef>
#include <vector>

#include "io/logs/cell_log.hpp"

namespace voltlap::plant {

struct OperatingGrid {
  std::vector<double> temperatures_c, currents_a;       ///< rising
  std::vector<std::size_t> temperature_of, current_of;  ///< of each recording, its place on the axes
};

/// Recordings by mean temperature (within 4 K) and, where each draws one current only, by that current (within 20 %);
/// one that stays below C/8 joins the nearest. One current of 0 stands for several.
[[nodiscard]] OperatingGrid operating_grid(const std::vector<CellLog>& logs, const std::vector<double>& temperatures_c);

}  // namespace voltlap::plant
