// SPDX-License-Identifier: Apache-2.0
#include "charge/drawn_cells.hpp"

#include <algorithm>
#include <random>

#include "core/demand.hpp"

namespace voltlap::plant {

double drawn_soc_spread(double asked, double soc) { return std::min({asked, soc, 1.0 - soc}); }

void draw_cells(const DrawnSpread& spread, std::uint64_t seed, VehicleParameters& car) {
  VOLTLAP_DEMAND(spread.soc >= 0.0 && spread.capacity >= 0.0 && spread.resistance >= 0.0);
  std::mt19937_64 random(seed);
  // By hand: the standard's distributions may differ from library to library.
  const auto within = [&](double size) {
    return size * (2.0 * static_cast<double>(random() >> 11U) * 0x1.0p-53 - 1.0);
  };
  car.battery.cells.resize(static_cast<std::size_t>(car.battery.cells_in_series));
  const double soc = car.battery.initial_soc;
  for (CellVariation& cell : car.battery.cells) {
    cell.initial_soc_offset = within(drawn_soc_spread(spread.soc, soc));
    cell.capacity_scale = 1.0 + within(spread.capacity);
    cell.resistance_scale = 1.0 + within(spread.resistance);
  }
}

}  // namespace voltlap::plant
