// SPDX-License-Identifier: Apache-2.0
// The rules of BMS-056 and BMS-058 on both sides of their bounds.
#include "bms/charge/progress.hpp"

#include "charge_bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;

TEST_GROUP(ProgressRule) {
  Config config = charge_config();
  State s;
  Charge& c = s.charge;
  ChargeProgress& p = s.charge.progress;
  void setup() override {
    s.cell_resistance = Resistance::from_raw(2'000);
    c.steered = Instant::from_ms(100);
    s.look.highest_now = charge_voltage(config);
  }
  bool reached(std::int32_t ma) {
    p.reached = false;
    s.measured.current.value = Current::from_raw(-ma);
    count_progress(config, Duration::from_ms(10), s);
    return p.reached;
  }
  Gain judge(std::int64_t gained_ma, std::int32_t ms = 600'000) {
    p.gained = gained_ma * 600'000;
    return judge_progress(config, p.since + Duration::from_ms(ms), s);
  }
};

// BMS-052: 2 mV, or what two steps of the charger make of it.
TEST(ProgressRule, AVoltageIsHeldWithinTwoMillivoltsOrTwoStepsOfTheCharger) {
  for (const std::int32_t uohm : {0, 2'000, 10'000}) LONGS_EQUAL(20, held_within(Resistance::from_raw(uohm)).raw());
  LONGS_EQUAL(21, held_within(Resistance::from_raw(10'500)).raw());
  LONGS_EQUAL(60, held_within(Resistance::from_raw(30'000)).raw());
}

// BMS-056
TEST(ProgressRule, WhatFlowsIntoThePackIsCountedAndBeginsAnew) {
  s.measured.current.value = Current::from_raw(-3'000);
  count_progress(config, Duration::from_ms(10), s);
  count_progress(config, Duration::from_ms(20), s);
  CHECK(p.gained == 90'000 && p.total == 90'000);
  s.measured.current.value = Current::from_raw(1'000);
  count_progress(config, Duration::from_ms(10), s);
  CHECK(p.gained == 80'000 && p.total == 80'000);
  p.reached = true;
  p.cooling = 3;
  begin_progress(Instant::from_ms(777), p);
  CHECK(p.gained == 0 && p.total == 0 && !p.reached && p.cooling == 0);
  LONGS_EQUAL(777, p.since.ms());
}

// BMS-056: the end current and a step more, or two steps.
TEST(ProgressRule, TheVoltageIsReachedByTheHighestCellUnderLittleCurrentAlone) {
  CHECK(reached(600));
  CHECK_FALSE(reached(601));
  CHECK(reached(-5'000));
  config.charge_current_end = Current::from_raw(100);
  CHECK(reached(200));
  CHECK_FALSE(reached(201));
  s.look.highest_now = charge_voltage(config) - CellVoltage::from_raw(20);
  CHECK(reached(0));
  s.look.highest_now = charge_voltage(config) - CellVoltage::from_raw(21);
  CHECK_FALSE(reached(0));
  s.look.highest_now = charge_voltage(config) + CellVoltage::from_raw(100);
  CHECK(reached(0));
  c.steered = c.entered;  // the highest cell is that of the charge before
  CHECK_FALSE(reached(0));
  c.steered = c.entered + Duration::from_ms(1);
  CHECK(reached(0));
  p.reached = true;  // it was, once
  s.measured.current.value = Current::from_raw(-5'000);
  count_progress(config, Duration::from_ms(10), s);
  CHECK(p.reached);
}

// BMS-056: half of the charger's step, a thousandth of the capacity an hour, half of the charger.
TEST(ProgressRule, InTenMinutesThePackGainsWhatItsSizeAndItsChargerAsk) {
  struct Case {
    std::int32_t capacity_mah, charger_ma, least_ma;
  };
  for (const Case& x : {Case{10'000, 20'000, 50}, Case{49'999, 20'000, 50}, Case{150'000, 20'000, 150},
                        Case{150'000, 200, 100}, Case{10'000, 100, 50}, Case{2'000'000, 600, 300}}) {
    config.capacity_mah = x.capacity_mah;
    config.charger_current_max = Current::from_raw(x.charger_ma);
    p = ChargeProgress{};
    CHECK(judge(x.least_ma) == Gain::kSome);
    CHECK(judge(x.least_ma - 1) == Gain::kNone);
  }
}

// BMS-056
TEST(ProgressRule, AWindowOfTenMinutesIsJudgedAtItsEndAndBeginsAnew) {
  p.since = Instant::from_ms(5'000);
  CHECK(judge(0, 599'999) == Gain::kSome);
  LONGS_EQUAL(5'000, p.since.ms());
  p.cooling = 3;
  p.gained = 50 * 600'000;
  p.reached = false;
  CHECK(judge(500) == Gain::kSome);
  LONGS_EQUAL(605'000, p.since.ms());
  CHECK(p.gained == 0 && p.cooling == 0 && !p.reached);
  p.reached = true;
  CHECK(judge(500) == Gain::kSome);
  CHECK_FALSE(p.reached);  // of the next window it says nothing
  CHECK(judge(0) == Gain::kNone);
}

// BMS-056: less than the end current, or than what counts as a gain at all.
TEST(ProgressRule, AReachedVoltageAndLittleGainAreFull) {
  for (const std::int32_t end_ma : {100, 500}) {
    config.charge_current_end = Current::from_raw(end_ma);
    config.capacity_mah = 300'000;  // 300 mA
    const std::int32_t most = std::max(end_ma, 300);
    p = ChargeProgress{};
    p.reached = true;
    CHECK(judge(most - 1) == Gain::kFull);
    CHECK(judge(0) == Gain::kFull);
    CHECK(judge(most) == Gain::kSome);
  }
}

// BMS-056: six windows without a gain.
TEST(ProgressRule, CellsThatAreTooHotHaveAnHourToCool) {
  c.reason = can::ChargeReason::kTemperature;
  for (int k = 1; k <= 6; ++k) {
    CHECK(judge(0) == Gain::kSome);
    LONGS_EQUAL(k, p.cooling);
  }
  CHECK(judge(0) == Gain::kNone);
  CHECK(judge(50) == Gain::kSome);  // a gain begins it anew
  LONGS_EQUAL(0, p.cooling);
  CHECK(judge(0) == Gain::kSome);
  c.reason = can::ChargeReason::kLimit;
  CHECK(judge(0) == Gain::kNone);
}

// BMS-058: 10 mV.
TEST(ProgressRule, WhileTheyAreBledTheCellsNeverComeTenMillivoltsFurtherApart) {
  CHECK(come_nearer(CellVoltage::from_raw(300), c));
  CHECK(come_nearer(CellVoltage::from_raw(400), c));
  CHECK_FALSE(come_nearer(CellVoltage::from_raw(401), c));
  CHECK(come_nearer(CellVoltage::from_raw(285), c));
  CHECK_FALSE(come_nearer(CellVoltage::from_raw(386), c));
}

// BMS-058: 0.5 mV, in one of three rounds.
TEST(ProgressRule, OfThreeRoundsOneBringsTheCellsNearer) {
  c.after_charging = true;
  c.balancing.known = true;
  const auto round = [&](std::int32_t spread) { return come_nearer(CellVoltage::from_raw(spread), c); };
  CHECK(round(300));
  CHECK_FALSE(c.balancing.known);  // the shunts begin anew
  CHECK(round(296));
  CHECK(round(300));
  LONGS_EQUAL(2, c.balancing.fruitless);
  CHECK(round(295));
  LONGS_EQUAL(0, c.balancing.fruitless);
  CHECK(round(291));
  CHECK(round(400));
  CHECK_FALSE(round(291));
  LONGS_EQUAL(3, c.balancing.fruitless);
  LONGS_EQUAL(295, c.balancing.round.raw());
}
