// SPDX-License-Identifier: Apache-2.0
#include "bms/voltage_check.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include "driven_bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;
using can::BmsFault;

TEST_GROUP(VoltageCheck) {
  DrivenBench car;
};

// BMS-062
TEST(VoltageCheck, OneCellsWorthAtSteadyCurrentTrips) {
  car.pack_gain = 1.02;  // of the pack's channel; learned at rest
  car.drive();
  car.run(5.0, 40.0);
  CHECK_FALSE(has(car.bench.out, BmsFault::kVoltageImplausible));
  car.pack_gain = 1.02 * 22.8 / 24.0;  // 1.2 cells less
  std::int32_t took = 0;
  while (!has(car.tick(40.0), BmsFault::kVoltageImplausible) && took < 5000) took += 10;
  expect_time("BMS-062", took, 1000, 1040);
}

TEST(VoltageCheck, LessThanACellOrAChangingCurrentDoesNotTrip) {
  car.drive();
  car.pack_gain = 23.1 / 24.0;
  car.run(20.0, 40.0);
  CHECK_FALSE(has(car.bench.out, BmsFault::kVoltageImplausible));
}

// BMS-063
TEST(VoltageCheck, WrongNumberOfCellsIsFoundAtRest) {
  for (const double cells : {23.0, 25.0}) {
    DrivenBench wrong;
    wrong.pack_gain = cells / 24.0;
    wrong.tick(0.0);
    expect_time("BMS-063", wrong.bench.until(sees(BmsFault::kVoltageImplausible), 5000), 990, 1100);
    wrong.bench.request(true);
    LONGS_EQUAL(-1, wrong.bench.until([](const Output& o) { return !all_open(o); }, 1000));
  }
}

TEST(VoltageCheck, ChannelsTwoAndAHalfPercentApartAreSound) {
  for (const double gain : {0.975, 1.025}) {
    DrivenBench sound;
    sound.pack_gain = gain;
    sound.drive();
    LONGS_EQUAL(-1, sound.lap_until([](const Output& o) { return o.faults != 0; }, 60.0));
    CHECK(sound.bench.out.state == can::BmsState::kTsActive);
  }
}

// BMS-022: cells and pack are held against each other as they were in one step.
TEST(VoltageCheck, CurrentThatIsChoppedFasterThanCellsAreReadIsNoDisagreement) {
  for (const int period : {2, 4, 6, 10, 20, 40}) {
    for (const bool lags : {false, true}) {
      DrivenBench chopped;
      std::vector<double> shown(24, 0.0);
      chopped.channel = [&](std::size_t k, double v) {
        shown[k] = shown[k] == 0.0 || !lags ? v : shown[k] + 0.05 * (v - shown[k]);  // 200 ms
        return shown[k];
      };
      chopped.drive();
      for (int i = 0; i < 1500; ++i) {
        CHECK_FALSE(has(chopped.tick(i % period < period / 2 ? 400.0 : 0.0), BmsFault::kVoltageImplausible));
      }
    }
  }
}

// BMS-022: a pack whose voltage swings hides an error for a while, and not for long.
TEST(VoltageCheck, AGainOfDrawnSizeUnderADrawnCurrentIsFoundWithinTwoSeconds) {
  std::int32_t worst = 0;
  for (unsigned seed = 1; seed <= 60; ++seed) {
    std::mt19937 random(seed);
    const auto drawn = [&](double low, double high) {
      return std::uniform_real_distribution<double>(low, high)(random);
    };
    DrivenBench wrong;
    wrong.scale = drawn(0.5, 3.5);
    wrong.drive();
    LONGS_EQUAL(-1, wrong.lap_until([](const Output& o) { return o.faults != 0; }, drawn(5.0, 10.0)));
    const double gain = 1.0 + (seed % 2 == 0 ? 1.0 : -1.0) * drawn(0.06, 0.3);
    wrong.pack_channel = [=](double v) { return v * gain; };
    double until_s = 0.0, amperes = 0.0;
    std::int32_t took = 0;
    for (; took <= 2'000; took += 10) {
      if (1e-3 * took >= until_s) {
        until_s += drawn(0.2, 2.0);
        amperes = amperes > 0.0 ? 0.0 : wrong.scale * drawn(0.0, 130.0);
      }
      if (has(wrong.tick(amperes), BmsFault::kVoltageImplausible)) break;
    }
    CHECK_TEXT(took <= 2'000, std::to_string(seed).c_str());
    worst = std::max(worst, took);
  }
  std::printf("BMS-022 under drawn currents: at most %d ms (bound 2000 ms)\n", worst);
}

// BMS-069
TEST(VoltageCheck, PackVoltageThatStandsStillWhileTheCellsMoveTrips) {
  car.drive();
  car.run(3.0, 40.0);
  double last = 0.0;
  bool frozen = false;
  car.pack_channel = [&](double v) { return frozen ? last : last = v; };
  car.run(1.0, 40.0);
  frozen = true;
  car.run(2.0, 40.0);
  CHECK_FALSE(has(car.bench.out, BmsFault::kVoltageImplausible));  // nothing has moved yet
  std::int32_t took = 0;
  while (!has(car.tick(120.0), BmsFault::kVoltageImplausible) && took < 5000) took += 10;
  expect_time("BMS-069", took, 1000, 1100);
  car.run(1.0, 40.0);
  CHECK(all_open(car.bench.out));
}

// BMS-069: a channel that has lost its pack is not always without noise.
TEST(VoltageCheck, AFrozenPackVoltageWithNoiseIsFoundToo) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> noise(-0.05, 0.05);  // 2 mV a cell
  double last = 0.0;
  bool frozen = false;
  car.pack_channel = [&](double v) { return frozen ? last + noise(random) : last = v; };
  car.drive();
  car.run(3.0, 40.0);
  frozen = true;
  CHECK(car.lap_until([](const Output& o) { return has(o, BmsFault::kVoltageImplausible); }, 10.0) > 0);
}

// BMS-069, wherever in a lap it freezes
TEST(VoltageCheck, PackVoltageThatFreezesInALapIsFoundWithinEightSeconds) {
  for (int number = 0; number < 12; ++number) {
    DrivenBench drives;
    double last = 0.0;
    bool frozen = false;
    drives.pack_channel = [&](double v) { return frozen ? last : last = v; };
    drives.drive();
    LONGS_EQUAL(-1, drives.lap_until([](const Output& o) { return o.faults != 0; }, 5.0 + 0.37 * number));
    frozen = true;
    const std::int32_t took =
        drives.lap_until([](const Output& o) { return has(o, BmsFault::kVoltageImplausible); }, 10.0);
    CHECK(took > 0 && took <= 8000);
  }
}

// BMS-069
TEST(VoltageCheck, CoarseLateAndNoisyChannelsThatStandAreSound) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    std::mt19937 random(seed);
    const auto drawn = [&](double low, double high) {
      return std::uniform_real_distribution<double>(low, high)(random);
    };
    const double step_v = drawn(0.001, 0.1), noise_v = drawn(0.0, 0.01), per_s = 0.01 / drawn(0.01, 0.3);
    const bool pack_is_late = seed % 2 == 0;
    DrivenBench sound;
    sound.scale = drawn(0.05, 2.0);
    double late = 0.0;
    sound.pack_channel = [&](double v) {
      late = late == 0.0 || !pack_is_late ? v : late + std::min(1.0, per_s) * (v - late);
      return step_v * std::round(late / step_v);
    };
    std::vector<double> shown(24, 0.0);
    std::normal_distribution<double> noise(0.0, noise_v);
    sound.channel = [&](std::size_t k, double v) {
      shown[k] = shown[k] == 0.0 || pack_is_late ? v : shown[k] + std::min(1.0, per_s) * (v - shown[k]);
      return shown[k] + noise(random);
    };
    sound.drive();
    for (int leg = 0; leg < 6; ++leg) {  // corners and straights, then the same current for long, then standing
      LONGS_EQUAL_TEXT(-1, sound.lap_until([](const Output& o) { return o.faults != 0; }, drawn(2.0, 12.0)),
                       ("seed " + std::to_string(seed)).c_str());
      sound.run(drawn(1.0, 8.0), drawn(0.0, 120.0));
      sound.run(drawn(1.0, 8.0), 0.0);
      LONGS_EQUAL_TEXT(0, sound.bench.out.faults, ("seed " + std::to_string(seed)).c_str());
    }
  }
}

TEST(VoltageCheck, CellsThatSumToNothingTeachNoGain) {
  Config config = pack_config();
  State s;
  s.measured.current.quality = s.measured.pack_voltage.quality = Quality::kGood;
  s.pack.cells_good = true;
  s.pack.sum_by_pack = PackVoltage::from_raw(900'000);
  check_pack_voltage(config, Instant{}, Duration::from_ms(10), s);
  CHECK_FALSE(s.voltage_check.gain_known);
  s.pack.cell_sum = PackVoltage::from_raw(900'000);
  check_pack_voltage(config, Instant{}, Duration::from_ms(10), s);
  LONGS_EQUAL(1'000'000, s.voltage_check.gain.raw());
}

// BMS-062: nobody knows what a cell is worth on a channel that was never seen at rest.
TEST(VoltageCheck, WithoutAGainNoCellIsMissing) {
  Config config = pack_config();
  State s;
  s.measured.current.quality = s.measured.pack_voltage.quality = Quality::kGood;
  s.pack.cells_good = s.contactors.closed_once = true;
  s.pack.cell_sum = PackVoltage::from_raw(936'000);
  s.pack.sum_by_pack = PackVoltage::from_raw(800'000);
  for (const bool known : {false, true}) {
    s.voltage_check.gain_known = known;
    s.voltage_check.gain = known ? Ratio::from_raw(1'000'000) : Ratio{};
    for (std::uint32_t ms = 0; ms < 1'000; ms += 10) {
      check_pack_voltage(config, Instant::from_ms(ms), Duration::from_ms(10), s);
    }
    CHECK(s.voltage_check.steady);
    CHECK_EQUAL(known, s.voltage_check.cell_missing);
  }
}
