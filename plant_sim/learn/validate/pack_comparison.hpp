// SPDX-License-Identifier: Apache-2.0
// One cell that stands for all of a pack, against every cell by itself (reference study, 2016, Appendix C): the
// plant's own pack (car/battery/pack.hpp) through a recorded current, once equal and once with cells that differ.
#pragma once
#include <cstdint>
#include <limits>

#include "learn/validate/prediction_error.hpp"

namespace voltlap::plant {

/// Standard deviations of the cells that differ, as of the virtual bench (data/bench/pulse_15.toml).
struct CellSpread {
  double capacity = 0.022;     ///< 1; reference study, 2016, section 7.3.2: 1.2 Ah
  double resistance = 0.03;    ///< 1; assumed
  double initial_soc = 0.004;  ///< 1; assumed
  std::uint64_t seed = 1;
};

/// Pack with one cell times their number minus the pack with all cells.
struct PackDifference {
  double voltage_mean_v = 0.0, voltage_rms_v = 0.0, voltage_max_v = 0.0;  ///< of the pack's voltage
  double soc_max = 0.0;                                                   ///< largest, of the mean SOC
  double snr = std::numeric_limits<double>::infinity();  ///< range of the voltage over the sigma of the difference
  double weakest_cell_v = 0.0;                       ///< how far the lowest cell lay below the mean of all, at most
  double voltage_low_v = 1e9, voltage_high_v = 0.0;  ///< of the pack with all cells
};

struct PackComparison {
  int cells = 24;
  PackDifference equal, differing;
};

[[nodiscard]] PackComparison compare_pack(const CellParameters& cell, const PlacedRecording& recording, int cells,
                                          const CellSpread& spread = {});

}  // namespace voltlap::plant
