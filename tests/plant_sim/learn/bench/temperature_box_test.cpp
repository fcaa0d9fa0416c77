// SPDX-License-Identifier: Apache-2.0
#include "learn/bench/temperature_box.hpp"

#include "bench_fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

TEST_GROUP(TemperatureBox) {
  BoxSection section = shipped_plan("pulse_15").box;
};

TEST(TemperatureBox, AirOfTheControlledBoxGoesAgainstTheDeviationWithinItsLimits) {
  TemperatureBox box(section, 30.0);
  box.control({31.0, 32.0, 31.0, 32.0});
  DOUBLES_EQUAL(30.0 - 5.0 * 1.5, box.air_c(), 1e-12);
  box.control({40.0, 40.0, 40.0, 40.0});
  DOUBLES_EQUAL(12.0, box.air_c(), 1e-12);
  box.control({0.0, 0.0, 0.0, 0.0});
  DOUBLES_EQUAL(60.0, box.air_c(), 1e-12);
}

TEST(TemperatureBox, PulseWaitsUntilEveryCellIsInTheBand) {
  const TemperatureBox box(section, 30.0);
  CHECK(box.ready({28.0, 32.0}));
  CHECK_FALSE(box.ready({30.0, 33.0}));
  CHECK_FALSE(box.ready({27.0, 30.0}));
}

TEST(TemperatureBox, FreeAirBalancesTheCellsHeatAgainstTheWalls) {
  section.mode = "free";
  TemperatureBox box(section, 26.0);
  box.control({40.0, 40.0});
  DOUBLES_EQUAL(26.0, box.air_c(), 0.0);
  constexpr double kCooling = 4.3;
  box.follow({40.0, 44.0}, kCooling);
  DOUBLES_EQUAL(kCooling * (42.0 - box.air_c()), section.loss_w_per_k * (box.air_c() - section.room_c), 1e-9);
  CHECK(box.ready({60.0, 20.0}));
}

TEST(TemperatureBox, OnlyTheFanAndTheBathChangeTheConvection) {
  DOUBLES_EQUAL(30.0, TemperatureBox(section, 30.0).convection_w_per_m2_k(7.0), 0.0);
  section.mode = "free";
  DOUBLES_EQUAL(7.0, TemperatureBox(section, 30.0).convection_w_per_m2_k(7.0), 0.0);
  section.mode = "bath";
  CHECK(TemperatureBox(section, 30.0).convection_w_per_m2_k(7.0) > 1e6);
}
