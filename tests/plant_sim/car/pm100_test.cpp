// SPDX-License-Identifier: Apache-2.0
#include "car/powertrain/pm100.hpp"

#include <cmath>
#include <random>

#include <CppUTest/TestHarness.h>
#include <fmt/format.h>

using namespace voltlap::plant;

namespace {

InverterSection section() {
  InverterSection inverter;
  inverter.current_max_a = 500.0;
  inverter.pm100_timeout_s = 0.05;
  return inverter;
}

}  // namespace

TEST_GROUP(Pm100Inverter) {
  Pm100 pm100{section(), 0.2};
  unsigned counter = 0;

  bool send(double torque_nm, bool enable = true, double limit_nm = 100.0) {
    return pm100.receive({torque_nm, limit_nm, true, enable, false, counter++ % 16U});
  }
};

TEST(Pm100Inverter, ObeysEnableOnlyAfterADisabledCommand) {
  CHECK(pm100.locked());
  send(50.0);
  CHECK_FALSE(pm100.enabled());
  send(0.0, false);
  CHECK_FALSE(pm100.locked());
  send(50.0);
  DOUBLES_EQUAL(50.0, pm100.torque_nm(), 1e-9);
}

TEST(Pm100Inverter, SilenceTripsItsTimeOutAndADisabledCommandEndsIt) {
  send(0.0, false);
  send(50.0);
  pm100.advance(0.05);
  CHECK(pm100.enabled());
  pm100.advance(0.01);
  CHECK(pm100.locked());
  LONGS_EQUAL(Pm100::kCommandLost, pm100.run_low());
  send(50.0);
  DOUBLES_EQUAL(0.0, pm100.torque_nm(), 1e-9);
  send(0.0, false);
  LONGS_EQUAL(0, pm100.run_low());
}

TEST(Pm100Inverter, ACounterThatDoesNotFollowIsNotObeyed) {
  send(0.0, false);
  send(10.0);
  ++counter;
  CHECK_FALSE(send(90.0));
  DOUBLES_EQUAL(10.0, pm100.torque_nm(), 1e-9);
  CHECK(send(20.0));
  --counter;
  CHECK_FALSE(send(90.0));
  DOUBLES_EQUAL(20.0, pm100.torque_nm(), 1e-9);
}

TEST(Pm100Inverter, LimitOfZeroIsThatOfTheEeprom) {
  send(0.0, false);
  send(80.0, true, 30.0);
  DOUBLES_EQUAL(30.0, pm100.torque_nm(), 1e-9);
  send(-400.0, true, 0.0);
  DOUBLES_EQUAL(-100.0, pm100.torque_nm(), 1e-9);
}

TEST(Pm100Inverter, AFaultStaysLockedWhateverIsSent) {
  send(0.0, false);
  pm100.fail_running(4);
  send(0.0, false);
  send(50.0);
  CHECK(pm100.locked());
  DOUBLES_EQUAL(0.0, pm100.torque_nm(), 1e-9);
}

TEST(Pm100Inverter, DrawnEventsNeverGiveTorqueBeforeTheLockoutIsReleased) {
  const unsigned seed = std::random_device{}();
  UT_PRINT(fmt::format("seed {}", seed).c_str());
  std::mt19937 draw(seed);
  bool released = false;
  int driven = 0;
  for (int k = 0; k < 200'000; ++k) {
    const unsigned event = draw() % 1000;
    if (event < 900) {
      const bool enable = draw() % 100 < 90;
      if (draw() % 100 < 3) counter += draw() % 16;  // lost, repeated, another sender
      const bool heard = send(80.0, enable);
      released = heard && !enable ? true : released && !pm100.locked();
    } else if (event < 990) {
      pm100.advance(0.001 * static_cast<double>(draw() % 30));
    } else if (event < 995) {
      pm100.advance(0.2);
    } else {
      pm100.lock();
    }
    released = released && !pm100.locked();
    CHECK(pm100.torque_nm() == 0.0 || released);
    driven += pm100.torque_nm() > 0.0 ? 1 : 0;
  }
  CHECK(driven > 1'000);
}
