// SPDX-License-Identifier: Apache-2.0
// What limits/ahead, limits/table and limits/energy_to_go keep from step to step.
#pragma once
#include <cstddef>
#include <cstdint>

#include "base/time.hpp"
#include "base/units.hpp"
#include "bms/config.hpp"
#include "bms/estimate/cell_model.hpp"

namespace voltlap::bms {

/// Of one cell, for each of kLimitHorizons [mA].
struct CellAhead {
  std::int32_t discharge[kLimitHorizonCount] = {}, charge[kLimitHorizonCount] = {};
};

/// What a cell beyond its bound has shown that it can do.
struct ShownLimit {
  Current most{};
  Instant seen{};  ///< the last reading beyond the bound
  std::uint8_t cell = 0;
  bool holds = false;
};

struct Ahead {
  CellAhead cell[kMaxCells] = {};
  std::uint8_t other = 0;  ///< whose turn it is beside the horizon that limits: 2 horizon + direction
  std::uint16_t other_cell = 0;  ///< the cell whose turn it is there
  bool began = false;            ///< some cell has been looked at
  ShownLimit shown_discharge{}, shown_charge{};
  PartFactors heat{0, 0, 0, 0, 0};  ///< heat_change() of the last tenth of a second
  std::int32_t scale = 0;  ///< of the cells' resistances, their mean [2^-28]
};

/// Shares of the maximum that limits/table has left.
struct LimitCaps {
  Ratio discharge = Ratio::from_raw(1'000'000), charge = Ratio::from_raw(1'000'000);
};

inline constexpr std::int32_t kPieceM = 100;  ///< of the way, after which limits/energy_to_go counts what it has taken
inline constexpr std::uint16_t kPiecesMost = 10'000;

/// What limits/energy_to_go knows of the distance. A cap of zero is none.
struct EnergyToGo {
  std::int64_t way = 0;       ///< since the last piece ended [rpm um/turn ms]
  std::uint16_t pieces = 0;   ///< driven, since the pack was charged
  std::uint8_t seen = 0;      ///< pieces in the mean of what is taken, at most ten
  bool began = false;
  std::int32_t taken = 0;     ///< of the charge in a piece, mean of late [2^-8 ppm]
  Soc at_mark{};              ///< when the last piece ended
  Current piece_peak{}, peak{};  ///< in this piece; of late
  Current cap{}, began_at{};  ///< now; when it began
};

}  // namespace voltlap::bms
