// SPDX-License-Identifier: Apache-2.0
// The clock of a table's rows, made to run forward by the rules of FrameClock.
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "io/logs/can/frame_clock.hpp"

namespace voltlap::plant {

struct RowClock {
  std::vector<std::size_t> row;  ///< in order of time; rows whose stamp is wrong are not among them
  std::vector<double> time_s;    ///< of those, one for each
  double rows_to_a_stamp = 0.0;  ///< after spread(), where the stamps are coarser than the rows; else 0
  std::vector<CanDefect> defects;  ///< `first_line` is a row, from 1
  std::vector<ClockPart> parts;    ///< likewise

  /// Where most rows have the stamp of the one before, they are samples one after the other, and the stamps are coarse:
  /// spreads them evenly up to the next stamp.
  void spread();
};

/// `stamps_s`: of each row [s]; NaN where it has none.
[[nodiscard]] RowClock row_clock(const std::vector<double>& stamps_s);

}  // namespace voltlap::plant
