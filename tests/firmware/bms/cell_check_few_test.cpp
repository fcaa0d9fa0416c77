// SPDX-License-Identifier: Apache-2.0
// Packs of one and of two cells: what the channel of a cell is held against when there are no neighbours, or one.
#include "bms/cell_check.hpp"

#include "driven_bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;
using can::BmsFault;

namespace {

Config pack_of(std::uint16_t cells) {
  Config config = pack_config();
  config.cells_in_series = cells;
  config.temperature_sensors = 1;
  return config;
}

bool any_fault(const Output& o) { return o.faults != 0; }

}  // namespace

TEST_GROUP(CellCheckFew){};

// BMS-060
TEST(CellCheckFew, AFrozenChannelIsFoundInAPackOfOneTwoOrThree) {
  for (const std::uint16_t cells : {std::uint16_t{1}, std::uint16_t{2}, std::uint16_t{3}}) {
    DrivenBench car(pack_of(cells));
    car.drive();
    LONGS_EQUAL(-1, car.lap_until(any_fault, 20.0));
    const double frozen_v = car.voltage(0);
    car.channel = [=](std::size_t k, double v) { return k == 0 ? frozen_v : v; };
    const auto told = [](const Output& o) {
      return has(o, BmsFault::kCellImplausible) && o.suspect == 0 && o.suspect_why == can::SuspectWhy::kNoResponse;
    };
    expect_time("BMS-060 few cells", car.lap_until(told), 1'000, 8'000);
  }
}

// BMS-060, BMS-061: of two none can be told to sag too much, and one is its own neighbour.
TEST(CellCheckFew, AWeakCellOfFewAccusesNoChannel) {
  for (const std::uint16_t cells : {std::uint16_t{1}, std::uint16_t{2}, std::uint16_t{3}}) {
    for (const double resistance : {0.7, 1.4, 3.0}) {
      DrivenBench car(pack_of(cells), 0.9);
      car.cells[0].resistance = resistance;
      car.cells[0].capacity = 0.9;
      car.drive();
      LONGS_EQUAL(-1, car.lap_until(any_fault, 120.0));
    }
  }
}

// BMS-061
TEST(CellCheckFew, ASingleCellThatReadsSomethingElseIsNoneOfItsOwnNeighbours) {
  for (const double off_v : {-0.15, 0.15}) {
    DrivenBench car(pack_of(1));
    car.drive();
    car.run(5.0, 7.0);
    car.channel = [=](std::size_t, double v) { return v + off_v; };
    car.bench.request(false);
    for (int i = 0; i < 1'000; ++i) CHECK_FALSE(has(car.tick(0.0), BmsFault::kCellImplausible));
  }
}

// BMS-061: for what a cell that sags more than fifteen times as much as the others lies lower is no sag any more.
TEST(CellCheckFew, AChannelTwoHundredTimesAsLowAsItsNeighboursSagIsOffItsLevel) {
  DrivenBench car(pack_config(), 0.9);
  car.drive();
  car.scale = 0.1;
  car.cells[3].resistance = 200.0;
  CHECK(car.lap_until(sees(BmsFault::kCellImplausible), 60.0) > 0);
  LONGS_EQUAL(3, car.bench.out.suspect);
  CHECK(car.bench.out.suspect_why == can::SuspectWhy::kLevel);
}
