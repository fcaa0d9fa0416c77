// SPDX-License-Identifier: Apache-2.0
#include "bms/balancing.hpp"

#include "bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;

TEST_GROUP(Balancing) {
  Bench bench;
  void setup() override {
    bench.cells(40'000);
    bench.cell_100uv[2] = 40'101;
    bench.idle();
  }
  bool any() {
    for (bool b : bench.state.balancing) {
      if (b) return true;
    }
    return false;
  }
};

TEST(Balancing, AsksForTheCellThatStandsAboveTheWeakestOnly) {
  for (std::size_t i = 0; i < 24; ++i) CHECK_EQUAL(i == 2, bench.state.balancing[i]);
}

TEST(Balancing, DifferenceIsTriedOnBothSides) {
  for (std::int32_t lsb : {-2, -1, 0, 1, 2}) {
    bench.cell_100uv[2] = 40'100 + lsb;
    bench.run(200);
    CHECK_EQUAL(lsb > 0, bench.state.balancing[2]);
  }
}

TEST(Balancing, CellAtOrBelowItsVoltageFloorIsNotDischarged) {
  bench.cells(38'000);
  for (std::int32_t lsb : {-1, 0, 1}) {
    bench.cell_100uv[2] = 39'000 + lsb;
    bench.run(200);
    CHECK_EQUAL(lsb > 0, bench.state.balancing[2]);
  }
}

// BMS-050
TEST(Balancing, StopsWithTheShutdownCircuitOpen) {
  bench.io.shutdown_closed = false;
  expect_time("BMS-050", bench.until([&](const Output&) { return !any(); }, 1000), 0, 100);
}

TEST(Balancing, StopsWithALatchedFaultThoughEveryMeasurementIsGoodAgain) {
  bench.cell_100uv[8] = 23'000;
  bench.run(700);
  bench.cell_100uv[8] = 40'000;
  bench.run(200);
  CHECK(bench.state.pack.cells_good && has(bench.out, can::BmsFault::kCellVoltageLow));
  CHECK_FALSE(any());
}

TEST(Balancing, StopsUnderLoadAndWithALostCell) {
  bench.drive();
  bench.current(amps(1) + Current::from_raw(1));
  bench.run(200);
  CHECK_FALSE(any());
  bench.current(amps(1));
  bench.run(200);
  CHECK(any());
  bench.invalid_cells.insert(9);
  bench.run(200);
  CHECK_FALSE(any());
}
