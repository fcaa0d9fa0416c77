// SPDX-License-Identifier: Apache-2.0
// What is asked of a charger, and what breaks a charge off, on both sides of each bound.
#include "charge_stage.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;
using can::ChargePhase;
using can::ChargeReason;

TEST_GROUP_BASE(ChargeSteer, ChargeStage){};

// BMS-052: 10 mV over 2 mOhm are 5 A, in 20 s, and in 4 s when it must fall.
TEST(ChargeSteer, TheHoldRisesInTwentySecondsAndFallsInFour) {
  c.hold_ua = 5'000'000;
  charging(5'000);
  room(100);
  steer();
  LONGS_EQUAL(5'025'000, c.hold_ua);
  room(-100);
  steer();
  LONGS_EQUAL(4'900'000, c.hold_ua);
  room(0);
  steer();
  LONGS_EQUAL(4'900'000, c.hold_ua);
  CHECK(c.steered.ms() == now_ms);
}

// BMS-052
TEST(ChargeSteer, ALateStepSteersByOneSecondAtMostAndAnEarlyOneByNone) {
  for (const std::int32_t late_ms : {-50, 0, 900, 1'000, 1'100, 60'000}) {
    c.hold_ua = 1'000'000;
    room(100);
    c.steered = now() + Duration::from_ms(-late_ms);
    c.entered = now() + Duration::from_ms(-100'000);
    run(true);
    LONGS_EQUAL(1'000'000 + 250 * std::clamp(late_ms, 0, 1'000), c.hold_ua);
  }
}

// BMS-052: a charger that gives less than it is asked for has wound the hold up, to 0.3 A above what flows.
TEST(ChargeSteer, WhenItMustFallTheHoldGoesOnFromWhatFlows) {
  charging(3'000);
  room(-4);  // takes 5 mA in this step
  for (const std::int32_t ua : {3'200'000, 3'300'000, 3'400'000, 9'000'000}) {
    c.hold_ua = ua;
    steer();
    LONGS_EQUAL(std::min(ua, 3'300'000) - 5'000, c.hold_ua);
  }
  room(0);
  c.hold_ua = 9'000'000;
  steer();
  LONGS_EQUAL(9'000'000, c.hold_ua);
}

// BMS-052
TEST(ChargeSteer, TheHoldIsNeverLessThanNothingNorMoreThanTheCharger) {
  room(-5'000);
  c.hold_ua = 1'000;
  steer();
  LONGS_EQUAL(0, c.hold_ua);
  room(20'000);
  c.hold_ua = 19'999'999;
  steer();
  LONGS_EQUAL(20'000'000, c.hold_ua);
  s.cell_resistance = Resistance{};
  c.hold_ua = 7'000'000;
  steer();
  LONGS_EQUAL(7'000'000, c.hold_ua);
  s.cell_resistance = Resistance::from_raw(1);
  room(1);
  steer();
  LONGS_EQUAL(7'500'000, c.hold_ua);
}

// BMS-052
TEST(ChargeSteer, WholeStepsOfTheLowerOneOfHoldAndLimitAreAsked) {
  room(0);
  c.hold_ua = 7'890'000;
  steer();
  LONGS_EQUAL(7'800, c.asked.raw());
  s.limits.charge.value = Current::from_raw(5'499);
  steer();
  LONGS_EQUAL(5'400, c.asked.raw());
  expect(ChargePhase::kCharging, ChargeReason::kNone);
  struct Case {
    std::int32_t limit_ma;
    can::LimitReason by;
    ChargeReason told;
  };
  for (const Case& x : {Case{100, can::LimitReason::kCellVoltage, ChargeReason::kNone},
                        Case{99, can::LimitReason::kCellVoltage, ChargeReason::kLimit},
                        Case{99, can::LimitReason::kTemperature, ChargeReason::kTemperature},
                        Case{100, can::LimitReason::kTemperature, ChargeReason::kNone}}) {
    s.limits.charge.value = Current::from_raw(x.limit_ma);
    s.limits.charge.reason = x.by;
    steer();
    LONGS_EQUAL(x.limit_ma / 100 * 100, c.asked.raw());
    expect(ChargePhase::kCharging, x.told);
  }
}

// BMS-053: what has stopped is told at once, and nothing else.
TEST(ChargeSteer, OnlyACurrentThatFallsToNothingIsToldAtOnce) {
  room(0);
  c.at_once = true;  // of the step before
  c.hold_ua = 7'000'000;
  steer();
  CHECK(c.asked > Current{} && !c.at_once);
  steer();
  CHECK(c.asked > Current{} && !c.at_once);
  c.hold_ua = 0;
  steer();
  CHECK(c.asked == Current{} && c.at_once);
  steer();
  CHECK(c.asked == Current{} && !c.at_once);
}

// BMS-052
TEST(ChargeSteer, BetweenTheTenthsOfASecondNothingIsSteered) {
  c.hold_ua = 7'000'000;
  room(100);
  c.steered = now() + Duration::from_ms(-50);
  run(false);
  LONGS_EQUAL(7'000'000, c.hold_ua);
  CHECK(c.asked == Current{});
  CHECK(c.progress.total == 0);
  charging(1'000);
  run(false, 20);
  CHECK(c.progress.total == 20'000);
}

// BMS-054: a twentieth and 1 A more than asked, for 5 s.
TEST(ChargeSteer, WhatFlowsUnaskedEndsItBeyondATwentiethAndOneAmpere) {
  for (const std::int32_t ma : {-1'001, -1'000, 22'000, 22'001}) {
    ChargeStage fresh;
    fresh.c.asked = Current::from_raw(20'000);
    fresh.charging(ma);
    fresh.run();
    fresh.now_ms += 4'990;
    fresh.run();
    fresh.expect(ChargePhase::kCharging, ChargeReason::kNone);
    fresh.now_ms += 10;
    fresh.run();
    const bool unasked = ma < -1'000 || ma > 22'000;
    fresh.expect(unasked ? ChargePhase::kStopped : ChargePhase::kCharging,
                 unasked ? ChargeReason::kCurrentNotAsked : ChargeReason::kNone);
  }
}

// BMS-053: half of the charger's step, for ten minutes.
TEST(ChargeSteer, WhereNothingFlowsOfWhatIsAskedForTenMinutesItEnds) {
  for (const std::int32_t ma : {49, 50}) {
    for (const std::int32_t asked_ma : {0, 100}) {
      ChargeStage fresh;
      fresh.c.asked = Current::from_raw(asked_ma);
      fresh.charging(ma);
      fresh.run();
      fresh.now_ms += 599'990;
      fresh.run();
      fresh.expect(ChargePhase::kCharging, ChargeReason::kNone);
      fresh.now_ms += 10;
      fresh.run();
      const bool none = ma < 50 && asked_ma > 0;
      fresh.expect(none ? ChargePhase::kStopped : ChargePhase::kCharging,
                   none ? ChargeReason::kNoCurrent : ChargeReason::kNone);
    }
  }
}

// BMS-056: the window of progress is over, and the pack has gained nothing.
TEST(ChargeSteer, WhatGainsNothingEndsByTheReasonThatItHas) {
  for (const bool limited : {false, true}) {
    ChargeStage fresh;
    fresh.room(200);
    if (limited) fresh.s.limits.charge.value = Current{};
    fresh.now_ms += 600'000;
    fresh.steer();
    fresh.expect(ChargePhase::kStopped, limited ? ChargeReason::kLimit : ChargeReason::kNoCurrent);
    CHECK_FALSE(fresh.c.wants_contactors);
  }
}

// BMS-052: held there by the end current for 10 s. At 2 mOhm held within 2 mV.
TEST(ChargeSteer, ItRestsWhenTheHighestCellIsHeldByTheEndCurrentForTenSeconds) {
  struct Case {
    std::int32_t left, hold_ua;
    bool full;
  };
  for (const Case& x : {Case{20, 499'999, true}, Case{21, 400'000, false}, Case{-1, 500'999, true},
                        Case{0, 501'000, false}}) {
    ChargeStage fresh;
    fresh.charging(400);
    fresh.room(x.left);
    fresh.c.entered = fresh.now() + Duration::from_ms(-60'000);
    fresh.s.look.samples[3] = 9;
    fresh.s.look.sum[3] = 9;
    for (int k = 0; k <= 100; ++k) {
      fresh.c.hold_ua = x.hold_ua - (x.left > 0 ? x.left * 250 : x.left * 1'250);  // what this step adds
      if (k == 100) CHECK(fresh.c.phase == ChargePhase::kCharging);
      fresh.steer();
      fresh.now_ms += 100;
    }
    CHECK_EQUAL(x.full, fresh.c.phase == ChargePhase::kResting);
    if (!x.full) continue;
    fresh.expect(ChargePhase::kResting, ChargeReason::kNone);
    CHECK(fresh.c.after_charging && fresh.c.at_once && fresh.c.asked == Current{});
    LONGS_EQUAL(0, fresh.s.look.samples[3]);
    LONGS_EQUAL(0, fresh.s.look.sum[3]);
    LONGS_EQUAL(0, fresh.c.hold_ua);
  }
}

// BMS-056: full without being held, for a current that goes on and off about nothing.
TEST(ChargeSteer, ItRestsAfterAWindowInWhichTheVoltageWasReachedAndLittleGained) {
  room(100);
  c.progress.reached = true;
  now_ms += 600'000;
  steer();
  expect(ChargePhase::kResting, ChargeReason::kNone);
}

// BMS-051: each thing that a charge does not begin without.
TEST(ChargeSteer, AWaitingChargeNamesWhatItWaitsForAndBeginsAnew) {
  const auto waits = [](ChargeReason why, const auto& change) {
    ChargeStage fresh;
    fresh.c = Charge{};
    fresh.c.phase = ChargePhase::kWaiting;
    fresh.c.hold_ua = 5'000'000;
    change(fresh);
    fresh.run();
    fresh.expect(why == ChargeReason::kNone ? ChargePhase::kCharging : ChargePhase::kWaiting, why);
    CHECK_EQUAL(why == ChargeReason::kNone, fresh.c.wants_contactors);
    LONGS_EQUAL(fresh.now_ms, fresh.c.did.ms());
    if (why == ChargeReason::kNone) LONGS_EQUAL(fresh.now_ms, fresh.c.progress.since.ms());
    CHECK(fresh.c.at_once == false);
  };
  waits(ChargeReason::kNone, [](ChargeStage&) {});
  waits(ChargeReason::kNoChargerInPack, [](ChargeStage& x) { x.config.charger_current_max = Current{}; });
  waits(ChargeReason::kMeasurementLost, [](ChargeStage& x) { x.s.pack.cells_good = false; });
  waits(ChargeReason::kMeasurementLost, [](ChargeStage& x) { x.s.pack.temperatures_good = false; });
  waits(ChargeReason::kMeasurementLost, [](ChargeStage& x) { x.s.measured.current.quality = Quality::kStale; });
  waits(ChargeReason::kMeasurementLost, [](ChargeStage& x) { x.s.contactors.state = can::BmsState::kInvalid; });
  waits(ChargeReason::kTemperature, [](ChargeStage& x) { x.s.pack.temperature_min = Temperature::from_raw(-1); });
  waits(ChargeReason::kNone, [](ChargeStage& x) { x.s.pack.temperature_min = Temperature::from_raw(0); });
  waits(ChargeReason::kTemperature, [](ChargeStage& x) { x.s.pack.temperature_max = x.config.derating_start; });
  ChargeStage open;
  open.c.phase = ChargePhase::kWaiting;
  open.s.contactors.state = can::BmsState::kIdle;
  open.run();
  expect(ChargePhase::kCharging, ChargeReason::kNone);
  open.expect(ChargePhase::kWaiting, ChargeReason::kNone);
  CHECK(open.c.wants_contactors);
  ChargeStage blocked;
  blocked.c.phase = ChargePhase::kWaiting;
  blocked.s.faults.open = true;
  blocked.run();
  blocked.expect(ChargePhase::kWaiting, ChargeReason::kFault);
}
