// SPDX-License-Identifier: Apache-2.0
// The rules of the pack voltage on both sides of their bounds.
#include "bms/voltage_check.hpp"
#include "bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;

TEST_GROUP(VoltageRule) {
  Config config = pack_config();
  State s;
  VoltageCheck& c = s.voltage_check;
  void setup() override {
    s.measured.current.quality = s.measured.pack_voltage.quality = Quality::kGood;
    s.pack.cells_good = true;
    s.cell_resistance = Resistance::from_raw(2'000);
    voltages(960'000, 960'000);
  }
  void voltages(std::int32_t by_pack, std::int32_t sum) {
    s.pack.sum_by_pack = PackVoltage::from_raw(by_pack);
    s.pack.cell_sum = PackVoltage::from_raw(sum);
  }
  void check(std::uint32_t ms, std::int32_t elapsed_ms = 10) {
    check_pack_voltage(config, Instant::from_ms(ms), Duration::from_ms(elapsed_ms), s);
  }
};

// BMS-063: three quarters of a cell's share, and never less than a sound channel's gain may be off.
TEST(VoltageRule, TheCountOfCellsIsWrongBeyondThreeQuartersOfACellOrAHundredth) {
  struct Case {
    std::uint16_t cells;
    std::int32_t most_ppm;
  };
  for (const Case& x : {Case{24, 31'250}, Case{144, 10'000}}) {
    for (const std::int32_t off : {-x.most_ppm - 1, -x.most_ppm, x.most_ppm, x.most_ppm + 1}) {
      s = State{};
      setup();
      config.cells_in_series = x.cells;
      voltages(1'000'000 + off, 1'000'000);
      check(0);
      LONGS_EQUAL(1'000'000 + off, c.gain.raw());
      CHECK_EQUAL(off < -x.most_ppm || off > x.most_ppm, c.count_wrong);
    }
  }
}

// BMS-063
TEST(VoltageRule, TheGainIsTheMeanOfASecondAtRestBeforeTheFirstClosing) {
  check(0);
  LONGS_EQUAL(1'000'000, c.gain.raw());
  voltages(979'200, 960'000);
  double gain = 1e6;
  for (std::uint32_t k = 1; k < 300; ++k) {
    check(10 * k);
    gain += (1'020'000 - gain) * 10.0 / 1'010.0;
    DOUBLES_EQUAL(gain, c.gain.raw(), 200.0);
  }
  const std::int32_t known = c.gain.raw();
  s.contactors.closed_once = true;
  voltages(900'000, 960'000);
  check(4'000);
  LONGS_EQUAL(known, c.gain.raw());
}

// BMS-062: a quarter of a cell's voltage, 20 A at 2 mOhm times 24 for 3.84 V.
TEST(VoltageRule, ACurrentIsSteadyWhileItHasMovedThePackByNoMoreThanAQuarterOfACell) {
  voltages(921'600, 921'600);
  for (const std::int32_t ma : {-20'050, -20'000, 20'000, 20'050}) {
    c = VoltageCheck{};
    s.measured.current.value = Current::from_raw(100'000);
    check(1'000);
    CHECK_FALSE(c.steady);
    check(1'390);
    CHECK_FALSE(c.steady);
    check(1'400);
    CHECK(c.steady);
    s.measured.current.value = Current::from_raw(100'000 + ma);
    check(1'410);
    const bool moved = ma < -20'000 || ma > 20'000;
    CHECK_EQUAL(!moved, c.steady);
    check(1'809);
    CHECK_EQUAL(!moved, c.steady);
    check(1'810);
    CHECK(c.steady);
  }
}

// BMS-062: more than a cell beside the gain, and 15 % of the pack's resistance in contacts.
TEST(VoltageRule, ACellIsMissingFromItsWorthAndWhatContactsMayTakeOn) {
  s.contactors.closed_once = c.gain_known = true;
  c.gain = Ratio::from_raw(2'000'000);  // so that the steps are whole
  for (const std::int32_t ma : {0, 100'000, -100'000}) {
    const std::int32_t most = 40'000 + (ma == 0 ? 0 : 7'200);  // 0.2 V times 24 times 15 %
    for (const std::int32_t apart : {-most - 1, -most, most, most + 1}) {
      c.steady_at = s.measured.current.value = Current::from_raw(ma);
      c.cell_missing = apart == most || apart == -most;
      voltages(2 * (960'000 + apart), 960'000);
      check(1'000);
      CHECK(c.steady);
      CHECK_EQUAL(apart < -most || apart > most, c.cell_missing);
    }
  }
}

// BMS-062, BMS-063
TEST(VoltageRule, WhatHasNotToAgreeIsNotHeldAgainstEachOther) {
  s.contactors.closed_once = c.gain_known = true;
  c.gain = Ratio::from_raw(1'000'000);
  voltages(860'000, 960'000);
  const State wrong = s;
  const auto missing = [&] {
    check(1'000);
    const bool told = c.cell_missing, steady = c.steady;
    CHECK_EQUAL(told, steady);
    s = wrong;
    c.steady = true;  // of the step before
    return told;
  };
  CHECK(missing());
  s.pack.cells_good = false;
  CHECK_FALSE(missing());
  s.measured.pack_voltage.quality = Quality::kStale;
  CHECK_FALSE(missing());
  s.measured.current.quality = Quality::kInvalid;
  CHECK_FALSE(missing());
  s.measured.some_bled = true;  // BMS-055
  CHECK_FALSE(missing());
  c.count_wrong = true;
  check(1'000);
  CHECK_FALSE(c.cell_missing);
  CHECK(c.steady);
  s = wrong;
  s.measured.current.value = amps(200);  // moves now
  CHECK_FALSE(missing());
}

// BMS-022: half of 5 %.
TEST(VoltageRule, ADifferenceLastsFromHalfOfWhatIsAllowedOnEitherWay) {
  voltages(1'000'000, 1'000'000);
  for (const std::int64_t apart : {-25'000, -24'999, 24'999, 25'000}) {
    c = VoltageCheck{};
    voltages(1'000'000, 1'000'000 - static_cast<std::int32_t>(apart));
    c.apart = apart;
    check(0, 0);
    CHECK_EQUAL(apart <= -25'000 || apart >= 25'000, c.lasting);
    c.apart = 0;  // a mean that says nothing
    check(0, 0);
    CHECK_FALSE(c.lasting);
  }
  c = VoltageCheck{};
  double mean = 0.0;
  voltages(1'000'000, 960'000);
  for (std::uint32_t k = 0; k < 100; ++k) {
    check(10 * k);
    mean += (40'000 - mean) * 10.0 / 210.0;
    DOUBLES_EQUAL(mean, static_cast<double>(c.apart), 30.0);
  }
}

// BMS-022: what a channel says that lags the other lies between what that one says and has said.
TEST(VoltageRule, NothingLastsBetweenWhatIsSaidAndWhatWasSaidAQuarterOfASecondAgo) {
  for (const bool pack_moves : {true, false}) {
    for (const std::int32_t off : {0, 24'999, 25'000}) {
      c = VoltageCheck{};
      const std::int32_t sum = pack_moves ? 900'000 - off : 1'100'000;
      voltages(1'000'000, sum);
      check(0);
      (pack_moves ? c.pack_late : c.sum_late) = pack_moves ? 900'000 : 1'000'000 + off;
      c.apart = pack_moves ? 100'000 : -100'000;
      check(10, 0);
      CHECK_EQUAL(off == 25'000, c.lasting);
    }
  }
  c = VoltageCheck{};
  double late = 960'000;
  voltages(960'000, 940'000);
  check(0);
  voltages(1'000'000, 900'000);
  for (std::uint32_t k = 1; k < 100; ++k) {
    check(10 * k);
    late += (1'000'000 - late) * 10.0 / 260.0;
    DOUBLES_EQUAL(late, static_cast<double>(c.pack_late), 30.0);
    DOUBLES_EQUAL(940'000 - (late - 960'000), static_cast<double>(c.sum_late), 30.0);
  }
}

// BMS-069: it stands within 5 mV a cell, the cells have moved by more than 20 mV each since a second after that.
TEST(VoltageRule, AChannelThatStandsForASecondIsFrozenWhenTheCellsHaveMovedSince) {
  for (const std::int32_t moved : {-4'801, -4'800, 4'800, 4'801}) {
    c = VoltageCheck{};
    voltages(960'000, 940'000);
    check(5'000);
    CHECK_FALSE(c.frozen);
    check(5'990);
    voltages(960'000 - 1'200, 960'000);
    check(6'000 - 1);
    CHECK_FALSE(c.frozen);  // lags are not over
    voltages(960'000 + 1'200, 960'000 + moved);
    check(6'000);
    CHECK_EQUAL(moved < -4'800 || moved > 4'800, c.frozen);
    check(20'000);
    CHECK_EQUAL(moved < -4'800 || moved > 4'800, c.frozen);
  }
}

// BMS-069
TEST(VoltageRule, AChannelThatMovesByFiveMillivoltsACellBeginsAnew) {
  for (const std::int32_t moved : {-1'201, -1'200, 1'200, 1'201}) {
    c = VoltageCheck{};
    voltages(960'000, 960'000);
    check(5'000);
    check(7'000);
    voltages(960'000 + moved, 970'000);
    check(7'100);
    const bool anew = moved < -1'200 || moved > 1'200;
    CHECK_EQUAL(!anew, c.frozen);
    LONGS_EQUAL(anew ? 7'100 : 5'000, c.still_since.ms());
    LONGS_EQUAL(anew ? 960'000 + moved : 960'000, c.still_at.raw());
  }
}

// BMS-069
TEST(VoltageRule, AChannelThatSaysNothingFromTheFirstStepIsWatchedFromThenOn) {
  voltages(0, 960'000);
  check(5'000);
  CHECK_FALSE(c.frozen);
  check(6'000);
  CHECK_FALSE(c.frozen);
  voltages(0, 960'000 + 4'801);
  check(6'010);
  CHECK(c.frozen);
}

// BMS-063
TEST(VoltageRule, TheLeastSumTeachesAGain) {
  voltages(1, 1);
  check(0);
  LONGS_EQUAL(1'000'000, c.gain.raw());
}
