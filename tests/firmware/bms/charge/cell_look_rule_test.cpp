// SPDX-License-Identifier: Apache-2.0
// What a look makes of each cell, the first and the last one too, and of no other.
#include "bms/charge/cell_look.hpp"

#include "charge_bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;

TEST_GROUP(CellLookRule) {
  Config config = charge_config();
  State s;
  CellLook& look = s.look;
  void setup() override {
    s.measured.arrived = 0xFFFF'FFFF'FFFF;
    for (std::size_t i = 0; i < kMaxCells; ++i) read(i, 40'000);
  }
  void read(std::size_t i, std::int32_t v, Quality quality = Quality::kGood) {
    s.measured.cell[i] = {CellVoltage::from_raw(v), Instant{}, quality};
  }
  bool take(int times) {
    bool done = false;
    for (int k = 0; k < times; ++k) done = take_look(config, s);
    return done;
  }
};

// BMS-055
TEST(CellLookRule, ALookKnowsTheLowestAndTheHighestCellWhereverTheyAre) {
  for (const std::size_t low : {0, 11, 23}) {
    for (const std::size_t high : {0, 12, 23}) {
      if (low == high) continue;
      setup();
      read(low, 39'000);
      read(high, 41'000);
      read(24, 10'000);  // of no cell of the pack
      begin_look(look);
      CHECK_FALSE(take(31));
      CHECK(take(1));
      CHECK(look.known);
      LONGS_EQUAL(39'000, look.lowest.raw());
      LONGS_EQUAL(41'000, look.highest.raw());
      for (std::size_t i = 0; i < 24; ++i) LONGS_EQUAL(s.measured.cell[i].value.raw(), look.cell[i].raw());
    }
  }
  config.cells_in_series = 1;
  begin_look(look);
  CHECK(take(32));
  LONGS_EQUAL(s.measured.cell[0].value.raw(), look.lowest.raw());
}

// BMS-055
TEST(CellLookRule, ALookThatBeginsAnewHasForgottenItsSamples) {
  for (std::size_t i = 0; i < 24; ++i) read(i, 30'001);
  CHECK_FALSE(take(31));
  begin_look(look);
  for (std::size_t i = 0; i < 24; ++i) LONGS_EQUAL(0, look.sum[i]);
  setup();
  CHECK_FALSE(take(31));
  CHECK(take(1));
  LONGS_EQUAL(40'000, look.lowest.raw());
  LONGS_EQUAL(40'000, look.highest.raw());
}

// BMS-055
TEST(CellLookRule, ALookIsIncompleteWithoutAnyOneCell) {
  for (const std::size_t lost : {0, 11, 23}) {
    setup();
    begin_look(look);
    read(lost, 40'000, Quality::kInvalid);
    CHECK_FALSE(take(100));
    read(lost, 40'000);
    CHECK(take(32));
  }
}

// BMS-055: command, filter of the channel and way of the reading.
TEST(CellLookRule, ACellIsReadUnderItsBleedUntilHalfASecondAfterTheLastShunt) {
  for (const std::size_t bled : {0, 23}) {
    s = State{};
    setup();
    s.cells_bled = 1;
    s.balancing[bled] = true;
    s.balancing[24] = true;  // of no cell of the pack
    mark_bled_cells(config, Instant::from_ms(1'000), s);
    s.cells_bled = 0;
    s.balancing[bled] = false;
    for (const std::uint32_t ms : {1'010U, 1'499U, 1'500U}) {
      mark_bled_cells(config, Instant::from_ms(ms), s);
      CHECK_EQUAL(ms < 1'500, s.measured.some_bled);
      for (std::size_t i = 0; i < kMaxCells; ++i) CHECK_EQUAL(i == bled && ms < 1'500, s.measured.bled[i]);
    }
  }
}

// BMS-052: of the means, over eight readings.
TEST(CellLookRule, TheHighestCellIsTheHighestMeanWhereverItIs) {
  for (const std::size_t high : {0, 11, 23}) {
    setup();
    read(high, 41'000);
    read(24, 50'000);  // of no cell of the pack
    look.mean[24] = 256 * 60'000;
    follow_highest(config, true, s);
    LONGS_EQUAL(41'000, look.highest_now.raw());
    LONGS_EQUAL(256 * 60'000, look.mean[24]);
    read(high, 40'800);
    follow_highest(config, false, s);
    LONGS_EQUAL(40'975, look.highest_now.raw());
    read(high, 20'000, Quality::kInvalid);
    follow_highest(config, false, s);
    LONGS_EQUAL(40'975, look.highest_now.raw());
    look.mean[24] = 0;
  }
}

// BMS-057: 10 mV.
TEST(CellLookRule, TheFloorIsTenMillivoltsBelowTheLowestCell) {
  look.lowest = CellVoltage::from_raw(39'000);
  set_floor(look);
  LONGS_EQUAL(38'900, look.floor.raw());
}

// BMS-058
TEST(CellLookRule, TheFarthestCellIsTheOneThatStandsFarthestFromTheMeanEitherWay) {
  const auto all_at = [&](std::int32_t v) {
    for (auto& cell : look.cell) cell = CellVoltage::from_raw(v);
  };
  all_at(40'000);
  LONGS_EQUAL(0, farthest_cell(config, look));
  look.cell[24] = CellVoltage::from_raw(60'000);  // of no cell of the pack
  LONGS_EQUAL(0, farthest_cell(config, look));
  for (const std::size_t far : {0, 11, 23}) {
    for (const std::int32_t off : {-100, 100}) {
      all_at(40'000);
      look.cell[5] = CellVoltage::from_raw(40'000 + off / 2);
      look.cell[6] = CellVoltage::from_raw(40'000 - off / 2);
      look.cell[far] = CellVoltage::from_raw(40'000 + off);
      LONGS_EQUAL(far, farthest_cell(config, look));
    }
  }
  config.cells_in_series = 2;
  for (const std::int32_t second : {200, 201, 202, 203}) {  // the mean is rounded down
    look.cell[0] = CellVoltage::from_raw(100);
    look.cell[1] = CellVoltage::from_raw(second);
    LONGS_EQUAL(second % 2 == 0 ? 0 : 1, farthest_cell(config, look));
  }
}
