// SPDX-License-Identifier: Apache-2.0
#include "master/pack_sag.hpp"

#include <cmath>
#include <cstdlib>
#include <random>
#include <string>

#include "CppUTest/TestHarness.h"
#include "firmware/master/bench.hpp"
#include "master/arbitration.hpp"

using namespace voltlap;
using namespace voltlap::master;

namespace {

unsigned drawn_seed() {
  const char* given = std::getenv("VOLTLAP_TEST_SEED");
  return given == nullptr ? std::random_device{}() : static_cast<unsigned>(std::stoul(given));
}

/// A pack that sags, under a drive of 95 %.
struct SoftPack {
  Config config{};
  Input in = bench::healthy(config);
  ArbitrationState state{};
  double open_v = 90.0, ohm = 0.05, noise_a = 0.0, speed_rpm = 4'000.0, pack_a = 0.0;
  std::mt19937 random{1};

  SoftPack() {
    for (Sample<Speed>& wheel : in.wheel_speed) wheel.value = Speed::from_raw(20'000);
  }
  void tick(double limit_a, std::int32_t request_ma) {
    const double watts = state.current.raw() * 1e-3 * 0.15 * speed_rpm * 0.104720 / 0.95;
    const double root = open_v * open_v - 4.0 * ohm * watts;
    pack_a = root < 0.0 ? open_v / (2.0 * ohm) : (open_v - std::sqrt(root)) / (2.0 * ohm);
    std::normal_distribution<double> error(0.0, 1.0);
    in.now = in.now + Duration::from_ms(10);
    bench::touch_all(in);
    in.phase_current = bench::good(state.current, in.now);
    in.motor_speed.value = MotorSpeed::from_raw(static_cast<std::int32_t>(speed_rpm));
    in.pack_current.value = Current::from_raw(static_cast<std::int32_t>(1e3 * (pack_a + noise_a * error(random))));
    in.pack_voltage.value = PackVoltage::from_raw(static_cast<std::int32_t>(1e4 * (open_v - ohm * pack_a)));
    in.discharge_limit.value = Current::from_raw(static_cast<std::int32_t>(1e3 * limit_a));
    arbitration_step(config, in, Current::from_raw(request_ma), Duration::from_ms(10), state);
  }
};

}  // namespace

TEST_GROUP(PackSag){};

// MST-030: a limit that a soft pack reaches with half its voltage left is kept from the first pull on. Of 30 000 drawn
// packs two went beyond it by more than 6 % for a moment, by 8.4 % at most: an ampere of noise in a step of R.
TEST(PackSag, ADcLimitHoldsHoweverFarTheVoltageFalls) {
  const unsigned seed = drawn_seed();
  std::mt19937 random(seed);
  const auto between = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
  int beyond = 0;
  for (int k = 0; k < 200; ++k) {
    SoftPack pack;
    pack.random.seed(seed + static_cast<unsigned>(k));
    pack.ohm = between(0.01, 0.15);
    pack.noise_a = between(0.0, 1.0);
    pack.speed_rpm = between(1'500.0, 6'000.0);
    pack.config.pack_resistance = Resistance::from_raw(static_cast<std::int32_t>(1e6 * pack.ohm * between(1.0, 1.5)));
    const double limit_a = between(0.2, 0.45) * pack.open_v / pack.ohm;  // the greatest power is at 0.5
    const double limit = limit_a > 900.0 ? 900.0 : limit_a;
    double most = 0.0, last = 0.0;
    for (int pull = 0; pull < 4; ++pull) {
      for (int t = 0; t < 30; ++t) pack.tick(limit, 0);
      for (int t = 0; t < 100; ++t) {
        pack.tick(limit, 550'000);
        if (pack.pack_a > most) most = pack.pack_a;
      }
      last = pack.pack_a;
    }
    const std::string what = "VOLTLAP_TEST_SEED=" + std::to_string(seed) + ", pack " + std::to_string(k) + ": " +
                             std::to_string(most) + " A of " + std::to_string(limit) + ", at the end " +
                             std::to_string(last);
    beyond += most > 1.06 * limit ? 1 : 0;
    CHECK_TEXT(most <= 1.1 * limit && beyond <= 2, what.c_str());
    const bool held = pack.state.reason == TorqueReason::kDischargeLimit;
    CHECK_TEXT(!held || last > 0.93 * limit, what.c_str());
  }
}

// MST-030
TEST(PackSag, ResistanceIsMeasuredFromSteps) {
  Config config{};
  config.pack_resistance = Resistance::from_raw(80'000);
  Input in = bench::healthy(config);
  PackSag sag;
  const auto step = [&](std::int32_t ma, std::int32_t unit_100uv) {
    in.now = in.now + Duration::from_ms(10);
    bench::touch_all(in);
    in.pack_current.value = Current::from_raw(ma);
    in.pack_voltage.value = PackVoltage::from_raw(unit_100uv);
    watch_pack_sag(in, sag);
    return pack_resistance(config, sag).raw();
  };
  LONGS_EQUAL(80'000, step(0, 900'000));
  const PackSag standing = sag;
  LONGS_EQUAL(50'000, step(20'000, 890'000));   // 1 V by 20 A are enough to tell
  sag = standing;
  LONGS_EQUAL(80'000, step(19'999, 891'000));   // 19.999 A are not
  LONGS_EQUAL(45'000, step(119'999, 846'000));  // 4.5 V by 100 A
  LONGS_EQUAL(45'000, step(0, 900'000));
  for (int t = 0; t < 600; ++t) (void)step(0, 900'000);
  LONGS_EQUAL(80'000, step(0, 900'000));  // long ago
  LONGS_EQUAL(0, step(200'000, 990'000));  // a voltage that rises with the load is no resistance
}

// MST-030
TEST(PackSag, AStepWithoutReadingBeginsAnew) {
  Config config{};
  Input in = bench::healthy(config);
  PackSag sag;
  const auto step = [&](std::int32_t ma, std::int32_t unit_100uv, bool fresh) {
    in.now = in.now + Duration::from_ms(10);
    if (fresh) bench::touch_all(in);
    in.pack_current.value = Current::from_raw(ma);
    in.pack_voltage.value = PackVoltage::from_raw(unit_100uv);
    watch_pack_sag(in, sag);
  };
  step(0, 900'000, true);
  step(0, 900'000, false);
  step(300'000, 600'000, true);
  LONGS_EQUAL(0, static_cast<long>(sag.squares));
  for (const bool voltage : {true, false}) {
    step(0, 900'000, true);
    CHECK(sag.followed);
    (voltage ? in.pack_voltage.quality : in.pack_current.quality) = Quality::kInvalid;
    step(0, 900'000, true);
    CHECK_FALSE(sag.followed);
    (voltage ? in.pack_voltage.quality : in.pack_current.quality) = Quality::kGood;
  }
  for (const bool voltage : {true, false}) {  // both of the same step, or no pair
    step(0, 900'000, true);
    in.now = in.now + Duration::from_ms(10);
    (voltage ? in.pack_voltage.time : in.pack_current.time) = in.now;
    watch_pack_sag(in, sag);
    CHECK_FALSE(sag.followed);
  }
}

// MST-030: 64 steps are the time constant: 37 % are left.
TEST(PackSag, WhatWasSeenIsForgotten) {
  Config config{};
  Input in = bench::healthy(config);
  PackSag sag;
  watch_pack_sag(in, sag);
  in.pack_current.value = Current::from_raw(100'000);
  in.pack_voltage.value = PackVoltage::from_raw(850'000);
  watch_pack_sag(in, sag);
  const std::int64_t squares = sag.squares, products = sag.products;
  CHECK(squares == 10'000'000'000 && products == 5'000'000'000);
  for (int t = 0; t < 64; ++t) watch_pack_sag(in, sag);
  for (const std::int64_t left_percent : {100 * sag.squares / squares, 100 * sag.products / products}) {
    CHECK(left_percent >= 36 && left_percent <= 38);
  }
}

// MST-030
TEST(PackSag, VoltageUnderTheLimitIsNeverBelowHalf) {
  Config config{};
  config.pack_resistance = Resistance::from_raw(100'000);
  Input in = bench::healthy(config);
  in.pack_current.value = Current::from_raw(100'000);
  const PackVoltage now = PackVoltage::from_raw(900'000);
  const auto at = [&](std::int32_t ma) { return voltage_at(config, in, now, Current::from_raw(ma), PackSag{}).raw(); };
  LONGS_EQUAL(800'000, at(200'000));
  LONGS_EQUAL(900'000, at(100'000));
  LONGS_EQUAL(900'000, at(50'000));
  LONGS_EQUAL(450'000, at(900'000));
  in.pack_current.quality = Quality::kStale;
  LONGS_EQUAL(900'000, at(900'000));
}
