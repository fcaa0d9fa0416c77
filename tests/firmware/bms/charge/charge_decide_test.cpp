// SPDX-License-Identifier: Apache-2.0
// What follows a look at the cells, a bleed and the switch, on both sides of each bound.
#include "charge_stage.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;
using can::ChargePhase;
using can::ChargeReason;

TEST_GROUP_BASE(ChargeDecide, ChargeStage) {
  void setup() override {
    c.phase = ChargePhase::kResting;
    c.after_charging = true;
    now_ms += 20'000;
    config.balancing_voltage_min = CellVoltage::from_raw(30'000);
  }
  /// The step in which the look is complete: cells at 39 mV more or less, one of them higher.
  void look(std::int32_t higher, std::size_t cell = 7) {
    for (std::size_t i = 0; i < 24; ++i) {
      s.look.samples[i] = 31;
      s.look.sum[i] = 31 * 39'000;
      s.measured.cell[i].value = CellVoltage::from_raw(39'000);
    }
    s.look.sum[cell] += 32 * higher;
    s.measured.arrived = 0xFF;
    run();
    s.measured.arrived = 0;
  }
};

// BMS-055: 20 s.
TEST(ChargeDecide, NoLookIsTakenBeforeTwentySecondsOfRest) {
  now_ms -= 10;
  look(0);
  expect(ChargePhase::kResting, ChargeReason::kNone);
  now_ms += 10;
  look(0);
  expect(ChargePhase::kFull, ChargeReason::kNone);
}

// BMS-055
TEST(ChargeDecide, ARestWithACurrentOrABleedIsNoneAndBeginsTheLookAnew) {
  for (const std::int32_t ma : {-1'001, -1'000, 1'000, 1'001}) {
    ChargeStage fresh;
    fresh.c.phase = ChargePhase::kResting;
    fresh.s.look.samples[3] = 5;
    fresh.charging(ma);
    fresh.c.not_asked = Persistence{};
    fresh.run();
    CHECK_EQUAL(ma < -1'000 || ma > 1'000 ? 0 : 5, fresh.s.look.samples[3]);
  }
  s.look.samples[3] = 5;
  s.measured.some_bled = true;
  run();
  LONGS_EQUAL(0, s.look.samples[3]);
}

// BMS-050, BMS-057: 3 mV.
TEST(ChargeDecide, EvenCellsAfterAChargeAreFull) {
  look(30);
  expect(ChargePhase::kFull, ChargeReason::kNone);
  CHECK_FALSE(c.wants_contactors || s.look.rested);
  LONGS_EQUAL(39'000 - 100, s.look.floor.raw());
}

// BMS-050
TEST(ChargeDecide, UnevenCellsAfterAChargeAreBled) {
  c.asked = Current{};
  look(31);
  expect(ChargePhase::kBleeding, ChargeReason::kNone);
  CHECK(c.wants_contactors);
  CHECK_FALSE(c.at_once);
  LONGS_EQUAL(now_ms, c.entered.ms());
}

// BMS-089
TEST(ChargeDecide, EvenCellsAfterABleedAreChargedAgainAndTheLookIsOneAtRest) {
  c.after_charging = false;
  c.progress.total = 9;
  s.look.floor = CellVoltage::from_raw(38'000);
  look(30);
  expect(ChargePhase::kCharging, ChargeReason::kNone);
  CHECK(s.look.rested);
  LONGS_EQUAL(38'000, s.look.floor.raw());
  CHECK(c.progress.total == 0);
  LONGS_EQUAL(now_ms, c.progress.since.ms());
  now_ms += 10;
  run();
  CHECK_FALSE(s.look.rested);
}

// BMS-057
TEST(ChargeDecide, CellsThatMayNotBeBledEndItByNameOrAreChargedAgain) {
  config.balancing_voltage_min = CellVoltage::from_raw(41'000);
  look(31);
  expect(ChargePhase::kStopped, ChargeReason::kNotBalanced);
  LONGS_EQUAL(7, c.off_cell);
  ChargeStage fresh;
  c = fresh.c;
  c.phase = ChargePhase::kResting;
  c.after_charging = false;
  c.entered = c.did = Instant::from_ms(now_ms - 20'000);
  look(31);
  expect(ChargePhase::kCharging, ChargeReason::kNone);
  CHECK(c.last == ChargeReason::kNone);  // nothing is given up: each has lost what it had too much
}

// BMS-058: filled once more, then it ends for what it was given up for, and names who was farthest then.
TEST(ChargeDecide, WhatIsGivenUpAfterABleedIsFilledOnceMoreAndThenEnds) {
  c.after_charging = false;
  c.bled_ms = config.balancing_time_max.ms();
  look(310, 7);
  expect(ChargePhase::kCharging, ChargeReason::kNone);
  CHECK(c.last == ChargeReason::kBalancingTime && c.wants_contactors);
  LONGS_EQUAL(7, c.off_cell);
  c.phase = ChargePhase::kResting;
  c.after_charging = true;
  now_ms += 20'000;
  look(310, 9);
  expect(ChargePhase::kStopped, ChargeReason::kBalancingTime);
  LONGS_EQUAL(7, c.off_cell);
  CHECK_FALSE(c.wants_contactors);
}

// BMS-058
TEST(ChargeDecide, WhatWasGivenUpIsNotBledAgain) {
  c.last = ChargeReason::kUneven;
  look(310);
  expect(ChargePhase::kStopped, ChargeReason::kUneven);
}

// BMS-058: and is full when that made them even.
TEST(ChargeDecide, WhatWasGivenUpIsFullWhereItIsEvenInTheEnd) {
  c.last = ChargeReason::kUneven;
  look(30);
  expect(ChargePhase::kFull, ChargeReason::kNone);
}

// BMS-058
TEST(ChargeDecide, CellsThatComeNoNearerAreGivenUp) {
  c.after_charging = false;
  c.balancing.known = true;
  c.balancing.least = CellVoltage::from_raw(100);
  for (const std::int32_t higher : {200, 201}) {
    c.phase = ChargePhase::kResting;
    c.entered = c.did = Instant::from_ms(now_ms - 20'000);
    look(higher);
    expect(higher == 200 ? ChargePhase::kBleeding : ChargePhase::kCharging, ChargeReason::kNone);
    CHECK_EQUAL(higher == 200, c.last == ChargeReason::kNone);
  }
  CHECK(c.last == ChargeReason::kUneven);
}

// BMS-058
TEST(ChargeDecide, TheTimeOfTheShuntsIsOverAtItsBound) {
  c.after_charging = false;
  c.bled_ms = config.balancing_time_max.ms() - 1;
  c.balancing.known = true;
  c.balancing.least = CellVoltage::from_raw(310);
  c.balancing.least_at_ms = c.bled_ms;
  look(310);
  expect(ChargePhase::kBleeding, ChargeReason::kNone);
}

// BMS-055: two minutes, and the time of shunts that are on.
TEST(ChargeDecide, ABleedEndsAfterTwoMinutesAndCountsItsShunts) {
  c.phase = ChargePhase::kBleeding;
  c.entered = now();
  s.look.samples[3] = 5;
  run(false, 20);
  LONGS_EQUAL(0, c.bled_ms);
  s.cells_bled = 1;
  run(false, 20);
  LONGS_EQUAL(20, c.bled_ms);
  now_ms += 119'990;
  run(false, 20);
  expect(ChargePhase::kBleeding, ChargeReason::kNone);
  LONGS_EQUAL(5, s.look.samples[3]);
  now_ms += 10;
  run(false, 20);
  expect(ChargePhase::kResting, ChargeReason::kNone);
  LONGS_EQUAL(60, c.bled_ms);
  LONGS_EQUAL(0, s.look.samples[3]);
  CHECK_FALSE(c.after_charging);
}

// BMS-058
TEST(ChargeDecide, ABleedEndsWhenTheTimeOfAllShuntsIsOver) {
  c.phase = ChargePhase::kBleeding;
  c.entered = now();
  s.cells_bled = 1;
  c.bled_ms = config.balancing_time_max.ms() - 11;
  run(false, 10);
  expect(ChargePhase::kBleeding, ChargeReason::kNone);
  run(false, 1);
  expect(ChargePhase::kResting, ChargeReason::kNone);
}

// BMS-050
TEST(ChargeDecide, ABleedThatWaitsForCoolerCellsSaysSo) {
  c.phase = ChargePhase::kBleeding;
  c.entered = now();
  s.pack.temperature_max = config.derating_start;
  run();
  expect(ChargePhase::kBleeding, ChargeReason::kTemperature);
  s.pack.temperature_max = config.derating_start - Temperature::from_raw(1);
  run();
  expect(ChargePhase::kBleeding, ChargeReason::kNone);
}

// BMS-056: an hour in which it neither charged nor bled.
TEST(ChargeDecide, AnHourOfNothingEndsItByWhatKeptIt) {
  const auto ends = [&](ChargeReason why, const auto& change) {
    for (const std::int32_t ms : {3'599'999, 3'600'000}) {
      ChargeStage x;
      x.c.phase = ChargePhase::kResting;
      x.now_ms += static_cast<std::uint32_t>(ms);
      change(x);
      x.run();
      const bool over = ms == 3'600'000 && why != ChargeReason::kNone;
      x.expect(over ? ChargePhase::kStopped : x.c.phase, over ? why : x.c.reason);
      CHECK_EQUAL(over, x.c.phase == ChargePhase::kStopped);
    }
  };
  ends(ChargeReason::kMeasurementLost, [](ChargeStage&) {});
  ends(ChargeReason::kMeasurementLost, [](ChargeStage& x) { x.charging(1'000); });
  ends(ChargeReason::kCurrentNotAsked, [](ChargeStage& x) { x.charging(1'001); });
  ends(ChargeReason::kCurrentNotAsked, [](ChargeStage& x) { x.charging(-1'001); });
  ends(ChargeReason::kTemperature, [](ChargeStage& x) { x.s.pack.temperature_max = x.config.derating_start; });
  ends(ChargeReason::kNone, [](ChargeStage& x) { x.s.cells_bled = 1; });
  ends(ChargeReason::kNone, [](ChargeStage& x) { x.c.phase = ChargePhase::kCharging; });
}

// BMS-052: a phase that begins anew has forgotten what the last one waited for.
TEST(ChargeDecide, APhaseBeginsWithoutWhatHeldInTheLastOne) {
  c.held.held(true, now(), Duration{});
  c.after_charging = false;
  c.reason = ChargeReason::kTemperature;
  look(30);
  expect(ChargePhase::kCharging, ChargeReason::kNone);
  CHECK_FALSE(c.held.held(true, now(), Duration::from_ms(10)));
}

// BMS-053: the charger is told for 5 s, for so long it would go on by itself.
TEST(ChargeDecide, ASwitchThatIsOffEndsEverythingAndIsToldForFiveSeconds) {
  c.phase = ChargePhase::kBleeding;
  c.bled_ms = 77;
  s.look.known = s.look.rested = true;
  s.measured.io.value.charge_switch = false;
  run();
  expect(ChargePhase::kNone, ChargeReason::kNone);
  CHECK(c.at_once && c.lingers);
  CHECK_FALSE(s.look.known || s.look.rested || c.wants_contactors);
  LONGS_EQUAL(0, c.bled_ms);
  const std::uint32_t off_ms = now_ms;
  LONGS_EQUAL(off_ms, c.entered.ms());
  now_ms += 10;
  run();
  CHECK(c.lingers && !c.at_once);
  now_ms = off_ms + 4'999;
  run();
  CHECK(c.lingers);
  now_ms = off_ms + 5'000;
  run();
  CHECK_FALSE(c.lingers || c.at_once);
  LONGS_EQUAL(off_ms, c.entered.ms());
  now_ms += 10;
  s.look.known = true;
  run();
  CHECK_FALSE(c.lingers);
  CHECK(s.look.known);  // there is nothing to end
  LONGS_EQUAL(off_ms, c.entered.ms());
}

// BMS-053
TEST(ChargeDecide, ASwitchThatIsOnAgainWithinFiveSecondsAndThenOffEndsTheChargeOnceMore) {
  s.measured.io.value.charge_switch = false;
  run();
  now_ms += 1'000;
  s.measured.io.value.charge_switch = true;
  run();
  CHECK(c.phase == ChargePhase::kCharging && c.lingers);
  now_ms += 1'000;
  s.measured.io.value.charge_switch = false;
  run();
  expect(ChargePhase::kNone, ChargeReason::kNone);
  CHECK(c.lingers && c.at_once);
  LONGS_EQUAL(now_ms, c.entered.ms());
}

// BMS-051: a switch that is not heard of is not one that is off.
TEST(ChargeDecide, WithoutTheVehiclesReportTheChargeIsBrokenOffByName) {
  s.measured.io.value.charge_switch = false;
  s.measured.io.quality = Quality::kStale;
  run();
  expect(ChargePhase::kStopped, ChargeReason::kShutdownCircuit);
}
