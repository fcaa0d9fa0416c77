// SPDX-License-Identifier: Apache-2.0
// State of charge by a Kalman filter of every cell (cell_filter.hpp), in turns: a tenth of the cells in every step,
// each 10 times a second. The charge itself is counted with every sample of the current, so that none is lost
// between turns.
//   start:  as soc_coulomb, each cell at its own OCV^-1(V), or from a record (soc_record.hpp)
//   pack:   SOC = mean over the cells
#pragma once
#include "bms/estimate/soc_estimator.hpp"

namespace voltlap::bms {

void soc_ekf(const Config& config, const SocInput& input, SocEstimate& state);

// BMS-085
/// Cells that take their turn in one step.
[[nodiscard]] constexpr std::uint16_t cells_in_turn(std::uint16_t cells) {
  return static_cast<std::uint16_t>((cells + 9) / 10);
}

/// Of one cell, within 0 and 1.
[[nodiscard]] constexpr Soc cell_soc(const SocEstimate& state, std::size_t cell) {
  return reported_soc(state.filter.cell[cell].filter.s);
}

}  // namespace voltlap::bms
