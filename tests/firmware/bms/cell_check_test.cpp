// SPDX-License-Identifier: Apache-2.0
#include "bms/cell_check.hpp"

#include "driven_bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;
using can::BmsFault;
using can::SuspectWhy;

TEST_GROUP(CellCheck) {
  DrivenBench car;
  void setup() override { car.drive(); }

  void check_suspect(SuspectWhy why, std::uint8_t cell) {
    CHECK(car.bench.out.suspect_why == why);
    LONGS_EQUAL(cell, car.bench.out.suspect);
  }
};

// BMS-060
TEST(CellCheck, FrozenChannelIsFoundWithinSecondsOfDriving) {
  LONGS_EQUAL(-1, car.lap_until([](const Output& o) { return o.faults != 0; }, 20.0));
  const double frozen_v = car.voltage(5);
  car.channel = [=](std::size_t k, double v) { return k == 5 ? frozen_v : v; };
  expect_time("BMS-060", car.lap_until(sees(BmsFault::kCellImplausible)), 1000, 8000);
  check_suspect(SuspectWhy::kNoResponse, 5);
  CHECK(all_open(car.bench.run(100)));
}

// BMS-060: a wire that has come off floats; its channel is not always quiet.
TEST(CellCheck, AFrozenChannelWithNoiseIsFoundToo) {
  for (int number = 0; number < 12; ++number) {
    std::mt19937 random(static_cast<unsigned>(number));
    const double sigma_v = std::uniform_real_distribution<double>(0.002, 0.02)(random);
    std::normal_distribution<double> noise(0.0, sigma_v);
    DrivenBench floats;
    floats.drive();
    LONGS_EQUAL(-1, floats.lap_until([](const Output& o) { return o.faults != 0; }, 12.0 + 0.37 * number));
    const double held_v = floats.voltage(5);
    floats.channel = [&](std::size_t k, double v) { return k == 5 ? held_v + noise(random) : v; };
    const std::int32_t took = floats.lap_until(sees(BmsFault::kCellImplausible));
    std::printf("BMS-060 with noise of %.1f mV: %d ms\n", 1e3 * sigma_v, took);
    CHECK(took > 0 && took <= 12'000);
  }
}

// BMS-060
TEST(CellCheck, ChannelsThatAreAllFrozenAreFoundByThePackVoltage) {
  LONGS_EQUAL(-1, car.lap_until([](const Output& o) { return o.faults != 0; }, 20.0));
  std::vector<double> held;
  for (std::size_t k = 0; k < 24; ++k) held.push_back(car.voltage(k));
  car.channel = [=](std::size_t k, double) { return held[k]; };
  expect_time("BMS-060 all", car.lap_until(sees(BmsFault::kCellImplausible)), 1000, 9000);
}

// BMS-060
TEST(CellCheck, FrozenChannelIsFoundFromPowerOn) {
  DrivenBench cold;
  cold.channel = [](std::size_t k, double v) { return k == 23 ? 3.9 : v; };
  cold.drive();
  expect_time("BMS-060 from power-on", cold.lap_until(sees(BmsFault::kCellImplausible)), 1000, 4000);
}

// BMS-060
TEST(CellCheck, FrozenChannelDoesNotAccuseWhileTheCurrentStandsStill) {
  const double frozen_v = car.voltage(5);
  car.channel = [=](std::size_t k, double v) { return k == 5 ? frozen_v : v; };
  for (int i = 0; i < 3000; ++i) CHECK_FALSE(has(car.tick(0.5), BmsFault::kCellImplausible));
}

// BMS-061
TEST(CellCheck, ChannelThatDriftsUpwardsIsFoundBeforeItIsWrongByThreeTenthsOfAVolt) {
  LONGS_EQUAL(-1, car.lap_until([](const Output& o) { return o.faults != 0; }, 20.0));
  double drift_v = 0.0;
  car.channel = [&](std::size_t k, double v) { return k == 9 ? v + drift_v : v; };
  const auto found = [&](const Output& o) {
    drift_v += 0.01 * 0.002;  // 2 mV a second
    return has(o, BmsFault::kCellImplausible);
  };
  CHECK(car.lap_until(found, 200.0) > 0);
  check_suspect(SuspectWhy::kLevel, 9);
  std::printf("BMS-061 drift upwards: found at %.0f mV (bound 300 mV)\n", 1e3 * drift_v);
  CHECK(drift_v < 0.3);
}

// BMS-061
TEST(CellCheck, ChannelThatReadsSixPercentTooMuchIsFoundAtRest) {
  DrivenBench wrong;
  wrong.channel = [](std::size_t k, double v) { return k == 3 ? 1.06 * v : v; };
  wrong.tick(0.0);
  expect_time("BMS-061 gain", wrong.bench.until(sees(BmsFault::kCellImplausible), 5000), 400, 2000);
  LONGS_EQUAL(3, wrong.bench.out.suspect);
  CHECK(wrong.bench.out.waits_for == can::WaitsFor::kFaultGone);
}

// BMS-061
TEST(CellCheck, ChannelThatReadsATenthTooLittleIsFoundUnderALittleLoad) {
  car.run(5.0, 7.0);
  car.channel = [](std::size_t k, double v) { return k == 3 ? 0.9 * v : v; };
  std::int32_t took = 0;
  while (!has(car.tick(7.0), BmsFault::kCellImplausible) && took < 20'000) took += 10;
  expect_time("BMS-061 gain 0.9", took, 1000, 10'000);
  LONGS_EQUAL(3, car.bench.out.suspect);
}

// BMS-061
TEST(CellCheck, ChannelsThatChangePlacesAreFoundWhereTheirCellsDiffer) {
  DrivenBench swapped;
  swapped.cells[4].soc -= 0.09;  // 108 mV
  swapped.drive();
  bool exchanged = false;
  swapped.channel = [&](std::size_t k, double v) {
    if (!exchanged || (k != 4 && k != 20)) return v;
    return swapped.voltage(k == 4 ? 20 : 4);
  };
  swapped.scale = 0.2;
  LONGS_EQUAL(-1, swapped.lap_until([](const Output& o) { return o.faults != 0; }, 20.0));
  exchanged = true;
  expect_time("BMS-061 swapped", swapped.lap_until(sees(BmsFault::kCellImplausible)), 1000, 25'000);
}

// BMS-060, BMS-061
TEST(CellCheck, WeakCellsOfEveryKindAreNoFaultOfTheirChannels) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0.0, 0.0015);
  DrivenBench weak(pack_config(), 0.9);
  weak.cells[1].capacity = 0.85;
  weak.cells[1].resistance = 1.4;
  weak.cells[2].resistance = 3.0;
  weak.cells[3].capacity = 1.1;
  weak.cells[4].resistance = 0.7;
  weak.cells[5].soc = 0.82;
  weak.channel = [&](std::size_t k, double v) { return v + noise(random) + (k % 2 == 0 ? 0.005 : -0.005); };
  weak.drive();
  LONGS_EQUAL(-1, weak.lap_until([](const Output& o) { return o.faults != 0; }, 300.0));
  std::printf("weak cells: none accused in 300 s, SOC %.2f\n", weak.cells[0].soc);
  CHECK(weak.cells[0].soc < 0.5);
}

// BMS-060
TEST(CellCheck, CellWhoseResistanceGrowsTwelvefoldAccusesNoChannel) {
  car.scale = 0.3;
  for (double grown = 1.0; grown < 12.0; grown += 0.1) {
    car.cells[3].resistance = grown;
    LONGS_EQUAL(-1, car.lap_until(sees(BmsFault::kCellImplausible), 1.0));
  }
}

namespace {

/// 144 cells are read every 100 ms, one group after the other.
Config long_pack() {
  Config config = pack_config();
  config.cells_in_series = 144;
  config.temperature_sensors = 36;
  return config;
}

}  // namespace

// BMS-060: the others have not been read since the step that this one has answered.
TEST(CellCheck, StepThatOnlyOneGroupHasSeenAccusesNoCell) {
  for (int wait = 6000; wait < 6144; wait += 36) {
    DrivenBench pack(long_pack(), 0.9);
    pack.drive();
    for (int i = 0; i < wait; ++i) CHECK_FALSE(has(pack.tick(80.0 + 0.001 * i), BmsFault::kCellImplausible));
    for (std::uint32_t group = 0; group < can::CellVoltages::kGroups; ++group) {
      if (group != 13) pack.bench.silent.insert(can::CellVoltages::kBaseId + group);
    }
    for (int i = 0; i < 300; ++i) {
      if (i == 25) pack.bench.silent.clear();  // two frames of each are lost
      CHECK_FALSE(has(pack.tick(1.0), BmsFault::kCellImplausible));
    }
  }
}

// BMS-060: a channel with a lag does not follow a current that is chopped, and is read at any moment of it.
TEST(CellCheck, LaggingChannelsUnderAChoppedCurrentAccuseNoCell) {
  for (const int period : {3, 5, 7, 11, 20, 31, 50, 97}) {
    DrivenBench lagging(pack_config(), 0.9);
    std::vector<double> shown(24, 0.0);
    lagging.channel = [&](std::size_t k, double v) {
      shown[k] = shown[k] == 0.0 ? v : shown[k] + 0.05 * (v - shown[k]);  // 200 ms
      return shown[k];
    };
    lagging.drive();
    for (int i = 0; i < 2000; ++i) {
      const double most = i / 400 % 2 == 0 ? 120.0 : 60.0;
      CHECK_FALSE(has(lagging.tick(i % period < period / 2 ? most : 0.0), BmsFault::kCellImplausible));
    }
  }
}
