// SPDX-License-Identifier: Apache-2.0
// What is renewed ten times a second: load, resistance and neighbours, by which a cell is judged.
#include <algorithm>
#include <cmath>
#include <random>

#include "bms/cell_check.hpp"
#include "bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;

TEST_GROUP(CellRenew) {
  Config config = pack_config();
  State s;
  CellCheck& c = s.cell_check;
  void setup() override { s.cell_resistance = Resistance::from_raw(2'000); }
  void renew(std::uint32_t ms = 0) { check_cells(config, Instant::from_ms(ms), true, s); }
};

// BMS-061
TEST(CellRenew, LoadIsTheMeanOfTenSecondsAndMakesSagAndRise) {
  std::mt19937 random(4);
  for (const bool loaded : {true, false}) {
    s = State{};
    s.cell_resistance = Resistance::from_raw(2'000);
    s.contactors.command.air_plus = loaded;
    const double tau_s = loaded ? 10.0 : 0.2;
    double load = 0.0, net = 0.0;
    bool charged = false, discharged = false;
    for (std::uint32_t k = 1; k < 600; ++k) {
      const double mean = k < 300 ? 100.0 : -100.0;
      const double amperes = mean + std::uniform_real_distribution(-200.0, 200.0)(random);
      s.measured.current.value = amps(amperes);
      renew(100 * k);
      load += (std::abs(amperes) - load) * 0.1 / (tau_s + 0.1);
      net += (amperes - net) * 0.1 / (tau_s + 0.1);
      DOUBLES_EQUAL(load, 1e-3 * c.load, 0.3);
      DOUBLES_EQUAL(net, 1e-3 * c.net, 0.3);
      LONGS_EQUAL(c.load * 2 / 100, c.sag);  // 2 mOhm
      DOUBLES_EQUAL(std::max(-net, 0.0) * 20.0, c.rise, 7.0);
      if (net > 1.0) LONGS_EQUAL(0, c.rise);
      charged = charged || net < -20.0;
      discharged = discharged || net > 20.0;
    }
    CHECK(charged && discharged);
  }
  const std::int32_t before = c.load;
  s.measured.current.value = amps(400);
  check_cells(config, Instant::from_ms(60'100), false, s);
  LONGS_EQUAL(before, c.load);
}

// BMS-061: the table's at least, three times it at most.
TEST(CellRenew, TheResistanceIsWhatThePackAnswersWhereTheCurrentExplainsIt) {
  s.measured.current.value = amps(100);
  s.contactors.command.air_plus = true;
  Covariance& answer = s.current_check.answer;
  answer.xx = 1'000'000'000;
  const auto answers_as = [&](std::int32_t uohm) { answer.xz = -24LL * uohm * 10'000; };
  answers_as(3'000);
  renew(100'000'000);  // long after the last: the load is there at once
  LONGS_EQUAL(3'000, c.resistance.raw());
  DOUBLES_EQUAL(3'000, c.sag, 2);  // 0.3 V
  answers_as(1'000);
  renew(200'000'000);
  LONGS_EQUAL(1'000, c.resistance.raw());
  DOUBLES_EQUAL(2'000, c.sag, 2);
  answers_as(7'000);
  renew(300'000'000);
  LONGS_EQUAL(6'000, c.resistance.raw());
  answers_as(-3'000);
  renew(400'000'000);
  LONGS_EQUAL(6'000, c.resistance.raw());  // a rise says nothing
  // 5 mV a cell: at 3 mOhm the square of 1.67 A.
  for (const std::int64_t ma : {1'640, 1'690}) {
    c.resistance = Resistance{};
    answer.xx = ma * ma;
    answer.xz = -24 * 3'000 * answer.xx / 100'000;
    renew(400'000'000);
    CHECK_EQUAL(ma == 1'690, c.resistance > Resistance{});
  }
}

// BMS-061: so that a bad cell accuses no sound one.
TEST(CellRenew, TheNeighboursAreAllCellsButTheLowest) {
  for (const std::size_t low : {std::size_t{0}, std::size_t{11}, std::size_t{23}}) {
    for (CellTrack& t : c.cell) t.level = 256 * 36'000;
    c.cell[5].level = 256 * 38'300;
    c.cell[6].level += 22;  // of 23 cells, rounded down
    c.cell[low].level = 256 * 30'000;
    renew();
    LONGS_EQUAL(256 * 36'100, c.level);
    LONGS_EQUAL(508'333, c.soc.raw());
  }
}

// BMS-061
TEST(CellRenew, OfOneOrTwoCellsNoneIsLeftOut) {
  for (const std::uint16_t cells : {std::uint16_t{1}, std::uint16_t{2}, std::uint16_t{3}}) {
    config.cells_in_series = cells;
    c.cell[0].level = 256 * 30'000;
    c.cell[1].level = 256 * 36'000;
    c.cell[2].level = 256 * 40'000;
    renew();
    LONGS_EQUAL(256 * (cells == 1 ? 30'000 : (cells == 2 ? 33'000 : 38'000)), c.level);
  }
}

// BMS-060: a tenth of it at least.
TEST(CellRenew, TheCellThatSagsMostLeavesItsRestToTheOthers) {
  const std::int64_t all = 1'000'000;
  const auto sags = [&](std::size_t cell, std::int64_t own) {
    c.cell[cell].xy = -256 * own;
    c.cell[cell].pack_answer.xz = c.cell[cell].x_lagged = -all;
  };
  const auto rest = [&] {
    renew();
    return c.rest;
  };
  for (std::size_t i = 0; i < 24; ++i) sags(i, 40'000);
  LONGS_EQUAL(960, rest());
  sags(7, 300'000);
  LONGS_EQUAL(700, rest());
  sags(0, 400'000);
  LONGS_EQUAL(600, rest());
  sags(23, 899'000);
  LONGS_EQUAL(101, rest());
  sags(23, 901'000);
  LONGS_EQUAL(100, rest());
  for (std::size_t i = 0; i < 24; ++i) sags(i, 1);
  LONGS_EQUAL(999, rest());
  for (CellTrack& t : c.cell) t.pack_answer.xz = t.x_lagged = -1;
  LONGS_EQUAL(100, rest());
  sags(23, 901'000);
  c.cell[23].x_lagged = 1;  // the pack answers the other way round
  LONGS_EQUAL(1'000, rest());
  for (CellTrack& t : c.cell) t.xy = 256'000;  // and so do the cells
  LONGS_EQUAL(1'000, rest());
  for (std::size_t i = 0; i < 24; ++i) sags(i, 300'000);
  config.cells_in_series = 2;
  LONGS_EQUAL(1'000, rest());
  config.cells_in_series = 3;
  LONGS_EQUAL(700, rest());
}

// BMS-061: 50 A at 2 mOhm, and a quarter of the current's changes is slow: a level that is wrong by 100 mV.
TEST(CellRenew, ACurrentWhoseQuarterIsSlowIsChoppedFromTenTimesAsMuch) {
  constexpr std::int64_t kSquare = 50'000LL * 50'000;
  struct Case {
    std::int64_t slow, fast;
    bool chopped;
  };
  for (const Case& x : {Case{kSquare / 3, 25'000'000, false}, Case{kSquare / 3, kSquare - 1, false},
                        Case{kSquare / 3, kSquare, true}, Case{kSquare / 3 - 2, kSquare - 1, true}}) {
    c.wave.slow = x.slow;
    c.wave.all = x.slow + x.fast;
    renew();
    CHECK_EQUAL(x.chopped, c.chopped);
  }
}

// BMS-061
TEST(CellRenew, AtTheFirstRestEveryCellsChargeIsThatOfItsVoltageAndStays) {
  s.pack.complete_once = s.pack.cells_good = true;
  for (std::size_t i = 0; i < 24; ++i) {
    s.measured.cell[i].value = CellVoltage::from_raw(33'000 + 120 * static_cast<std::int32_t>(i));
    s.measured.cell_current[i] = amps(3);  // 6 mV
    s.measured.cell_pack[i] = PackVoltage::from_raw(900'000);
  }
  s.measured.cell[0].value = CellVoltage::from_raw(33'002);
  s.measured.cell[24].value = CellVoltage::from_raw(40'000);  // of no cell of the pack
  const State fresh = s;
  s.cell_resistance = Resistance{};
  renew();
  CHECK_FALSE(c.based);
  s = fresh;
  s.pack.complete_once = false;
  renew();
  CHECK_FALSE(c.based);
  s = fresh;
  renew();
  CHECK(c.based);
  LONGS_EQUAL(370'006, c.start.raw());  // 3.306 V, 11.5 steps of 12 mV, and 167 / 24
  LONGS_EQUAL(255'167, c.cell[0].start.raw());
  LONGS_EQUAL(485'000, c.cell[23].start.raw());
  LONGS_EQUAL(256 * 33'062, c.cell[0].level);
  LONGS_EQUAL(256 * 33'002, c.cell[0].voltage);
  LONGS_EQUAL(900'000, c.cell[0].pack);
  CHECK(c.cell[0].begun);
  s.measured.cell[0].value = CellVoltage::from_raw(40'000);
  renew(100);
  LONGS_EQUAL(370'006, c.start.raw());
  LONGS_EQUAL(255'167, c.cell[0].start.raw());
}

// BMS-061: a level is no level while the current is chopped; what was counted stays.
TEST(CellRenew, AChoppedCurrentJudgesNoLevel) {
  s.measured.arrived = 1;
  s.measured.current.quality = s.measured.pack_voltage.quality = s.measured.cell[0].quality = Quality::kGood;
  c.wave.begun = c.cell[0].begun = c.based = true;
  c.soc = c.start = c.cell[0].start = Soc::from_raw(500'000);
  c.level = 256 * 36'000;
  c.cell[0].level = 256 * 40'000;
  c.cell[0].off_level = 3;
  c.chopped = true;
  check_cells(config, Instant{}, false, s);
  LONGS_EQUAL(3, c.cell[0].off_level);
  c.chopped = false;
  check_cells(config, Instant{}, false, s);
  LONGS_EQUAL(4, c.cell[0].off_level);
}
