// SPDX-License-Identifier: Apache-2.0
// What a recording's counted charge is off by, as far as it shows itself: rests that end alike are one state.
//
//   z_ij = (q_j - q_i) / C - (V_i - V_j) / (dOCV/ds)      counted, less what the voltages differ by: a drift's alone
//   d    = sum w t_ij z_ij / sum w t_ij^2                 of all pairs; t_ij hours under current
//   w    = 1 / (s0^2 + (V0 / (dOCV/ds))^2)                V0 = 2 mV, s0 = 0.2 % of the charge: as rests do
// The voltage is that ten minutes after the current ended, and pairs are after a charge both or after a discharge both,
// so that what is left of a relaxation or of a hysteresis is the same in both. Flat stretches of the OCV tell nothing.
#pragma once
#include <optional>
#include <vector>

#include "car/battery/cell_tables.hpp"
#include "io/logs/cell_log.hpp"

namespace voltlap::plant {

struct CountDrift {
  double current_a = 0.0;          ///< counted beside what flows, discharge positive
  int rests = 0;                   ///< that end like another
  std::vector<double> drawn_ah;    ///< without it, row by row
};

struct CountedCell {
  double capacity_ah, temperature_c;
  double rest_a;  ///< at more current nothing rests
};

/// Nothing where no two rests end alike, where it is more than a hundredth of the largest current, or where it is
/// within three times of what such rests may differ by.
/// `drawn_ah`: as it was counted.
[[nodiscard]] std::optional<CountDrift> count_drift(const CellLog& log, const std::vector<double>& drawn_ah,
                                                    const CellTables& tables, const CountedCell& cell);

}  // namespace voltlap::plant
