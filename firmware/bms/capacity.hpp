// SPDX-License-Identifier: Apache-2.0
// Most cells and thermistors that the BMS has memory for: as many as its frames carry. An image for a smaller pack is
// built with -DVOLTLAP_CELLS_MAX=N, which puts a file of this name with other numbers before this one.
#pragma once
#include <cstddef>

#include "can_dbc/car.hpp"

namespace voltlap::bms {

inline constexpr std::size_t kMaxCells = can::CellVoltages::kGroups * can::CellVoltages::kPerFrame;
inline constexpr std::size_t kMaxTemperatures = can::Temperatures::kGroups * can::Temperatures::kPerFrame;

}  // namespace voltlap::bms
