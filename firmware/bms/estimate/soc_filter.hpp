// SPDX-License-Identifier: Apache-2.0
// What soc_ekf keeps from step to step: the curves in its units, a filter a cell, and up to where each has counted.
#pragma once
#include <cstddef>
#include <cstdint>

#include "base/time.hpp"
#include "bms/config.hpp"
#include "bms/estimate/cell_filter.hpp"

namespace voltlap::bms {

/// One cell with what its filter has to be told.
struct FilteredCell {
  CellFilter filter{};
  Instant stepped{};             ///< when
  std::int64_t charge = 0;       ///< counted until then [half mA ms]
};

struct SocFilter {
  CellModel model{};
  FilteredCell cell[kMaxCells] = {};
  std::int64_t sum = 0;              ///< of s over the cells [2^-28]
  PartFactors warm{};                ///< what the temperature makes of the parts
  Temperature heat_of{};             ///< that it belongs to
  Temperature heat_began{};          ///< the first that was known
  bool heat_known = false;
  std::uint16_t next = 0;            ///< the cell whose turn it is
  std::int32_t per_charge = 0;       ///< SOC of a count [2^-28 2^-charge_bits]
  std::uint8_t charge_bits = 0;
  bool restored = false;             ///< the cells hold what a record said, and have not started yet
};

}  // namespace voltlap::bms
