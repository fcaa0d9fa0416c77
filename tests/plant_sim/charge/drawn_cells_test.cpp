// SPDX-License-Identifier: Apache-2.0
#include "charge/drawn_cells.hpp"

#include <cmath>

#include "fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

TEST_GROUP(DrawnCells) {
  VehicleParameters car = vtm16e();
  const DrawnSpread spread{.soc = 0.02, .capacity = 0.03, .resistance = 0.1};
};

TEST(DrawnCells, EveryCellDiffersWithinTheSpreadAndTheSameSeedDrawsTheSame) {
  car.battery.initial_soc = 0.5;
  VehicleParameters again = car, other = car;
  draw_cells(spread, 7, car);
  draw_cells(spread, 7, again);
  draw_cells(spread, 8, other);
  UNSIGNED_LONGS_EQUAL(24, car.battery.cells.size());
  double largest = 0.0;
  for (std::size_t i = 0; i < 24; ++i) {
    const CellVariation& cell = car.battery.cells[i];
    CHECK(std::abs(cell.initial_soc_offset) <= 0.02 && std::abs(cell.capacity_scale - 1.0) <= 0.03);
    CHECK(std::abs(cell.resistance_scale - 1.0) <= 0.1);
    largest = std::max(largest, std::abs(cell.initial_soc_offset));
    DOUBLES_EQUAL(cell.capacity_scale, again.battery.cells[i].capacity_scale, 0.0);
    CHECK(cell.capacity_scale != other.battery.cells[i].capacity_scale);
  }
  CHECK(largest > 0.01);
}

TEST(DrawnCells, NoCellBeginsBelowEmptyOrAboveFull) {
  for (const double soc : {0.0, 1.0}) {
    car.battery.initial_soc = soc;
    draw_cells(spread, 3, car);
    for (const CellVariation& cell : car.battery.cells) {
      CHECK(soc + cell.initial_soc_offset >= 0.0 && soc + cell.initial_soc_offset <= 1.0);
    }
  }
}
