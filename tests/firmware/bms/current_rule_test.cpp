// SPDX-License-Identifier: Apache-2.0
// The rules of the current sensor on both sides of their bounds.
#include "bms/current_check.hpp"

#include <cmath>
#include <random>

#include "bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;

TEST_GROUP(CurrentRule) {
  Config config = pack_config();
  State s;
  CurrentCheck& c = s.current_check;
  void setup() override {
    s.cell_resistance = Resistance::from_raw(2'000);
    for (Quality* q : {&s.measured.io.quality, &s.measured.current.quality, &s.measured.pack_voltage.quality,
                       &s.measured.phase_current.quality, &s.measured.motor_speed.quality,
                       &s.measured.dc_link_voltage.quality}) {
      *q = Quality::kGood;
    }
  }
  void learn(std::int32_t ma, std::uint32_t ms = 0) {
    learn_current_offset(Current::from_raw(ma), Instant::from_ms(ms), s);
  }
  /// Of the readings of one step; without time nothing is forgotten and nothing learned.
  void check(std::int32_t elapsed_ms = 0) {
    check_current(config, Instant{}, Duration::from_ms(elapsed_ms), s);
  }
};

// BMS-068
TEST(CurrentRule, AnOffsetOfFiveAmperesIsOneEitherWay) {
  for (const std::int32_t ma : {-5'001, -5'000, 5'000, 5'001}) {
    learn(ma);
    CHECK_EQUAL(ma < -5'000 || ma > 5'000, c.offset_too_large);
  }
  LONGS_EQUAL(2, c.readings);
}

// BMS-068: lag of sensor and contactor.
TEST(CurrentRule, AnOffsetIsLearnedHalfASecondAfterTheOpeningAndNeverUnderACommand) {
  s.contactors.closed_once = true;
  s.contactors.opened_at = Instant::from_ms(1'000);
  learn(1'000, 1'499);
  LONGS_EQUAL(0, c.readings);
  learn(1'000, 1'500);
  LONGS_EQUAL(1, c.readings);
  s.contactors.command.precharge = true;
  learn(1'000, 9'000);
  LONGS_EQUAL(1, c.readings);
  s.contactors.command.precharge = s.contactors.closed_once = false;
  learn(1'000, 1'000);  // nothing was ever closed
  LONGS_EQUAL(2, c.readings);
  s.measured.io.quality = Quality::kStale;
  learn(1'000, 9'000);
  LONGS_EQUAL(2, c.readings);
}

// BMS-068
TEST(CurrentRule, TheFirstSixteenReadingsAreOneMeanAndTheNextHardlyMoveIt) {
  for (int k = 0; k < 15; ++k) learn(k % 2 == 0 ? 1'000 : 3'000);
  CHECK_FALSE(c.offset_known);
  LONGS_EQUAL(0, c.offset.raw());
  learn(3'000);
  CHECK(c.offset_known);
  DOUBLES_EQUAL(2'000, c.offset.raw(), 16.0);
  const std::int32_t mean = c.offset.raw();
  learn(4'000);
  DOUBLES_EQUAL(mean + 2'000 * 0.01 / 10.01, c.offset.raw(), 1.0);
}

// BMS-068
TEST(CurrentRule, ThenItIsAMeanOfTenSeconds) {
  for (const std::int32_t ma : {2'000, -2'000}) {
    s = State{};
    setup();
    for (int k = 0; k < 16; ++k) learn(0);
    for (int k = 0; k < 1'000; ++k) learn(ma);
    DOUBLES_EQUAL(ma * -std::expm1(-1.0), c.offset.raw(), 20.0);
    for (int k = 0; k < 12'000; ++k) learn(ma);
    DOUBLES_EQUAL(ma, c.offset.raw(), 1.0);
  }
}

// BMS-066
TEST(CurrentRule, TheAnswerOfThePackIsThatOfItsTwinInDoublePrecision) {
  std::mt19937 random(8);
  for (const bool loaded : {true, false}) {
    s = State{};
    setup();
    s.contactors.command.air_plus = loaded;
    const double memory_s = loaded ? 4.0 : 0.2;
    double current = 0, voltage = 0, x_mean = 0, z_mean = 0, xx = 0, xz = 0, amperes = 100.0;
    for (int k = 0; k < 1'000; ++k) {
      if (k % 40 == 0) amperes = std::uniform_real_distribution(-200.0, 400.0)(random);
      const double volts = 90.0 - 0.05 * amperes;
      if (k == 0) {
        current = amperes;
        voltage = volts;
      }
      const auto follow = [](double& mean, double x, double tau_s) { mean += (x - mean) * 0.01 / (tau_s + 0.01); };
      follow(current, amperes, 1.6);
      follow(voltage, volts, 1.6);
      const double dx = amperes - current - x_mean, dz = volts - voltage - z_mean;
      follow(x_mean, amperes - current, memory_s);
      follow(z_mean, volts - voltage, memory_s);
      follow(xx, dx * dx, memory_s);
      follow(xz, dx * dz, memory_s);
      s.measured.current.value = amps(amperes);
      s.measured.pack_voltage.value = PackVoltage::from_raw(static_cast<std::int32_t>(std::lround(1e4 * volts)));
      check(10);
      DOUBLES_EQUAL(current, 1e-3 * c.current, 0.5);
      DOUBLES_EQUAL(voltage, 1e-4 * c.voltage, 0.03);
      DOUBLES_EQUAL(xx, 1e-6 * static_cast<double>(c.answer.xx), 10.0 + 0.01 * xx);
      DOUBLES_EQUAL(xz, 1e-7 * static_cast<double>(c.answer.xz), 0.5 - 0.01 * xz);
    }
  }
}

// BMS-066: 15 % of the table's resistance, the wrong way round.
TEST(CurrentRule, AVoltageThatRisesWithTheCurrentByMoreThanFifteenPercentIsReversed) {
  c.answer.xx = 666'666'000'000;
  for (const std::int64_t more : {0, 1}) {
    c.answer.xz = 24 * (2'000'000'000 + more);
    check();
    CHECK_EQUAL(more == 1, c.reversed);
  }
  c.answer.xz = -c.answer.xz;
  check();
  CHECK_FALSE(c.reversed);
  s.cell_resistance = Resistance::from_raw(100);  // 5 mV a cell, too, for it may be noise
  c.answer.xx = 400'000'000;
  for (const double share : {0.98, 1.02}) {
    c.answer.xz = static_cast<std::int64_t>(share * 24 * 50 * 20'000);
    check();
    CHECK_EQUAL(share > 1.0, c.reversed);
  }
}

// BMS-066
TEST(CurrentRule, WithoutAResistanceNoSagIsJudged) {
  c.answer.xx = 1'000'000'000;
  c.answer.xz = 48'000'000'000;
  for (const std::int32_t uohm : {-1, 0, 1}) {
    s.cell_resistance = Resistance::from_raw(uohm);
    check();
    CHECK_EQUAL(uohm > 0, c.reversed);
  }
}

// BMS-066: eight times the table's resistance, and 20 mV a cell.
TEST(CurrentRule, ACurrentIsFrozenWhereItExplainsLessThanTheVoltageMoves) {
  c.answer.xx = 100'000'000;
  for (const std::int64_t zz : {5'760'000, 5'760'001}) {  // 10 A, 8 * 24 * 2 mOhm: 3.84 V
    c.answer.zz = zz;
    check();
    CHECK_EQUAL(zz == 5'760'001, c.frozen);
  }
  c.answer.xx = 0;
  for (const std::int64_t zz : {89'999, 90'000}) {  // 0.48 V
    c.answer.zz = zz;
    check();
    CHECK_EQUAL(zz == 90'000, c.frozen);
  }
  for (const std::int32_t uohm : {104'167, 104'172}) {  // 2.5 ohm: beyond it the product is not inside 64 bits
    s.cell_resistance = Resistance::from_raw(uohm);
    check();
    CHECK_EQUAL(uohm == 104'167, c.frozen);
  }
}

// BMS-067: 60 % of the shaft's power, and twice of it with 6 kW more.
TEST(CurrentRule, ThePowerOfTheBatteryIsHeldAgainstTheShafts) {
  config.motor_constant_unm_per_a = 95'500;
  s.measured.dc_link_voltage.value = PackVoltage::from_raw(900'000);
  c.shaft = 10'000'000;
  for (const std::int64_t mw : {5'999'999, 6'000'000, 26'000'000, 26'000'001}) {
    c.battery = mw;
    check();
    CHECK(c.power_judged);
    CHECK_EQUAL(mw < 6'000'000 || mw > 26'000'000, c.power_wrong);
  }
  for (const std::int64_t mw : {7'999'999, 8'000'000}) {
    c.shaft = mw;
    check();
    CHECK_EQUAL(mw == 8'000'000, c.power_judged);
  }
}

// BMS-067: an induced voltage of 30 V against 50 V.
TEST(CurrentRule, ThePowerIsJudgedUpToSixTenthsOfTheDcLink) {
  config.motor_constant_unm_per_a = 95'500;
  c.shaft = 10'000'000;
  for (const std::int32_t rpm : {-3'000, 3'000}) {
    for (const std::int32_t link : {499'999, 500'000}) {
      s.measured.motor_speed.value = MotorSpeed::from_raw(rpm);
      s.measured.dc_link_voltage.value = PackVoltage::from_raw(link);
      check();
      CHECK_EQUAL(link == 500'000, c.power_judged);
    }
  }
}

// BMS-067: 300 V/1000 rpm at 95.5 mNm/A, means of half a second.
TEST(CurrentRule, BothPowersAreMeansOfHalfASecond) {
  config.motor_constant_unm_per_a = 95'500;
  s.measured.motor_speed.value = MotorSpeed::from_raw(3'000);
  s.measured.phase_current.value = amps(100);
  s.measured.pack_voltage.value = PackVoltage::from_raw(900'000);
  s.measured.current.value = amps(50);
  check(500);
  CHECK(c.shaft == 1'500'000);
  CHECK(c.battery == 2'250'000);
}

// BMS-067
TEST(CurrentRule, AnyReadingThatIsMissingLeavesThePowerUnjudged) {
  config.motor_constant_unm_per_a = 95'500;
  c.shaft = 10'000'000;
  s.measured.dc_link_voltage.value = PackVoltage::from_raw(900'000);
  const auto judged = [&] {
    c.power_judged = true;  // of the step before
    check();
    return c.power_judged;
  };
  CHECK(judged());
  for (Quality* q : {&s.measured.phase_current.quality, &s.measured.motor_speed.quality,
                     &s.measured.dc_link_voltage.quality}) {
    *q = Quality::kStale;
    CHECK_FALSE(judged());
    *q = Quality::kGood;
  }
  config.motor_constant_unm_per_a = 0;
  CHECK_FALSE(judged());
  s.measured.phase_current.quality = s.measured.motor_speed.quality = Quality::kStale;
  CHECK_FALSE(judged());
  config.motor_constant_unm_per_a = 1;
  s.measured.phase_current.quality = s.measured.motor_speed.quality = Quality::kGood;
  CHECK(judged());
}

// BMS-066: one frame has both, and is taken once.
TEST(CurrentRule, OnlyReadingsOfThisStepAreTaken) {
  s.measured.current.quality = Quality::kStale;
  check();
  s.measured.current.quality = Quality::kGood;
  s.measured.pack_voltage.quality = Quality::kStale;
  check();
  s.measured.pack_voltage.quality = Quality::kGood;
  check_current(config, Instant::from_ms(1), Duration{}, s);
  CHECK_FALSE(c.begun);
  check();
  CHECK(c.begun);
}
