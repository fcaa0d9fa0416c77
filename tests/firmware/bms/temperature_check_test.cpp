// SPDX-License-Identifier: Apache-2.0
#include "bms/temperature_check.hpp"

#include "bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;
using can::BmsFault;

TEST_GROUP(TemperatureCheck) {
  Bench bench;
  void setup() override { bench.drive(); }
  std::int32_t time_to(BmsFault fault, std::int32_t most_ms = 10'000) {
    return bench.until([=](const Output& o) { return has(o, fault); }, most_ms);
  }
};

// BMS-064
TEST(TemperatureCheck, JumpOfAThermistorTrips) {
  bench.temperature_dc[4] += 120;
  expect_time("BMS-064 rate", time_to(BmsFault::kTemperatureImplausible), 990, 1110);
  CHECK(bench.out.suspect_why == can::SuspectWhy::kRate);
  LONGS_EQUAL(4, bench.out.suspect);
}

TEST(TemperatureCheck, PackThatWarmsTenTimesAsFastAsUnderFullLoadDoesNotTrip) {
  for (int s = 0; s < 60; ++s) {
    for (auto& t : bench.temperature_dc) t += 5;  // 0.5 K/s
    bench.run(1000);
    CHECK_FALSE(has(bench.out, BmsFault::kTemperatureImplausible));
  }
}

// BMS-064
TEST(TemperatureCheck, ThermistorFarFromItsNeighboursTrips) {
  Bench apart;
  apart.temperature_dc[2] = 250 - 251;
  expect_time("BMS-064 spread",
              apart.until([](const Output& o) { return has(o, BmsFault::kTemperatureImplausible); }, 5000), 900, 1400);
  CHECK(apart.out.suspect_why == can::SuspectWhy::kSpread);
  LONGS_EQUAL(2, apart.out.suspect);
  Bench near;
  near.temperature_dc[2] = 250 - 249;
  LONGS_EQUAL(-1, near.until([](const Output& o) { return has(o, BmsFault::kTemperatureImplausible); }, 5000));
}

// BMS-065
TEST(TemperatureCheck, OpenAndShortedThermistorsAreLostOnes) {
  for (const std::int32_t end : {-400, -390, 1'200, 1'250}) {
    Bench broken;
    broken.drive();
    broken.temperature_dc[1] = end;
    expect_time("BMS-065",
                broken.until([](const Output& o) { return has(o, BmsFault::kTemperatureMeasurementLost); }, 3000), 400,
                510);
  }
}
