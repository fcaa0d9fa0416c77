// SPDX-License-Identifier: Apache-2.0
#include "bms/voltage_check.hpp"

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
