// SPDX-License-Identifier: Apache-2.0
#include "car/powertrain/dc_link.hpp"

#include <cmath>

#include "fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

TEST_GROUP(DcLink) {
  ContactorSection section = vtm16e().contactors;
  DcLink link{section};
};

TEST(DcLink, PrechargeFollowsTheCurveOfResistorAndCapacitor) {
  constexpr double kStep = 1e-4;
  const double share = 4700.0 / 4800.0;  // the bleed resistor takes its part
  const double tau = 0.001 * 100.0 * share;
  double t = 0.0;
  for (int i = 0; i < 5000; ++i) {
    link.advance(100.0, 0.0, 1.0 / 100.0, 0.0, kStep);
    t += kStep;
    DOUBLES_EQUAL(100.0 * share * (1.0 - std::exp(-t / tau)), link.voltage(), 0.05);
  }
}

TEST(DcLink, PrechargeReachesNinetyFivePercentAfterThreeTimeConstants) {
  section.bleed_resistance_ohm = 1e7;
  DcLink ideal(section);
  for (int ms = 0; ms < 300; ++ms) ideal.advance(100.0, 0.0, 1.0 / 100.0, 0.0, 0.001);
  DOUBLES_EQUAL(95.0, ideal.voltage(), 0.2);
}

TEST(DcLink, AnOpenPathLeavesTheCapacitorToTheBleedResistor) {
  for (int ms = 0; ms < 2000; ++ms) link.advance(100.0, 0.01, 2000.0, 0.0, 0.001);
  DOUBLES_EQUAL(100.0, link.voltage(), 0.01);
  double t = 0.0;
  while (link.voltage() > 60.0 && t < 20.0) {
    DOUBLES_EQUAL(0.0, link.advance(100.0, 0.01, 0.0, 0.0, 0.001).pack_current_a, 0.0);
    t += 0.001;
  }
  CHECK(t < 5.0);  // EV.7.2.2
  DOUBLES_EQUAL(4.7 * std::log(100.0 / 60.0), t, 0.01);
}

TEST(DcLink, ConstantPowerLoadTakesExactlyItsPower) {
  DcLinkStep step;
  for (int ms = 0; ms < 100; ++ms) step = link.advance(100.0, 0.05, 2000.0, 20000.0, 0.001);
  DOUBLES_EQUAL(20.0, step.load_j, 1e-9);
  CHECK_FALSE(step.collapsed);
  // Steady: the source's current feeds load and bleed.
  DOUBLES_EQUAL(20000.0 + link.voltage() * link.voltage() / 4700.0, link.voltage() * step.pack_current_a, 1e-3);
}

TEST(DcLink, EnergyOfEveryStepAddsUp) {
  for (int i = 0; i < 300; ++i) {
    const double load = i < 100 ? 0.0 : i < 200 ? 15000.0 : -8000.0;
    const DcLinkStep s = link.advance(100.0, 0.05, i < 50 ? 0.01 : 2000.0, load, 0.001);
    const double behind_resistance_v = 100.0 - 0.05 * s.pack_current_a;
    DOUBLES_EQUAL(behind_resistance_v * s.pack_current_a * 0.001, s.load_j + s.bleed_j + s.path_j + s.stored_j, 1e-10);
  }
}

TEST(DcLink, RegenerationChargesThePack) {
  DcLinkStep step;
  for (int ms = 0; ms < 100; ++ms) step = link.advance(100.0, 0.05, 2000.0, 0.0, 0.001);
  for (int ms = 0; ms < 100; ++ms) step = link.advance(100.0, 0.05, 2000.0, -5000.0, 0.001);
  CHECK(step.pack_current_a < -45.0);
  CHECK(link.voltage() > 100.0);
}

TEST(DcLink, MorePowerThanThePackCanGiveIsFlaggedAndBounded) {
  // A source of 100 V behind 50 mOhm can give 50 kW; the capacitor carries the first milliseconds.
  DcLinkStep step;
  for (int ms = 0; ms < 100; ++ms) step = link.advance(100.0, 0.05, 2000.0, 45000.0, 0.001);
  CHECK_FALSE(step.collapsed);
  for (int ms = 0; ms < 100; ++ms) step = link.advance(100.0, 0.05, 2000.0, 60000.0, 0.001);
  CHECK(step.collapsed);
  CHECK(step.load_j < 60.0);
  CHECK(link.voltage() > 0.0);
}
