// SPDX-License-Identifier: Apache-2.0
// The isolation monitor and the interlock, as VehicleIo reports them.
#include "bms/faults.hpp"

#include "bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;
using can::BmsFault;
using can::BmsState;
using can::WaitsFor;

TEST_GROUP(Isolation) {
  Bench bench;

  bool closes() {
    bench.request(false);
    bench.run(100);
    bench.request(true);
    return bench.until([](const Output& o) { return o.state == BmsState::kTsActive; }, 3000) >= 0;
  }
  void reset() {
    bench.request(false);
    bench.master.reset_request = false;
    bench.run(50);
    bench.master.reset_request = true;
    bench.run(50);
    bench.master.reset_request = false;
    bench.run(50);
  }
  static bool tripped(const Output& o) { return has(o, BmsFault::kIsolationFault); }
};

// BMS-036
TEST(Isolation, AFaultTripsAndStaysUntilItHasGoneAndTheVehicleIsReset) {
  bench.drive();
  bench.io.isolation_fault = true;
  expect_time("BMS-036", bench.until(tripped, 1000), 90, 110);
  CHECK(bench.out.state == BmsState::kFault);
  LONGS_EQUAL(0, bench.out.limits.discharge.value.raw());
  bench.run(100);
  CHECK(all_open(bench.out));
  reset();
  CHECK(tripped(bench.out));  // it is still there
  bench.io.isolation_fault = false;
  bench.run(1000);
  CHECK(tripped(bench.out));
  CHECK_FALSE(closes());
  reset();
  LONGS_EQUAL(0, bench.out.faults);
  CHECK(closes());
}

// BMS-036: a monitor that opens the shutdown circuit itself is not forgotten because nothing was closed any more.
TEST(Isolation, AFaultIsLatchedWhenItsMonitorHasOpenedTheShutdownCircuitBefore) {
  bench.drive();
  bench.io.isolation_fault = true;
  bench.io.shutdown_closed = false;
  expect_time("BMS-030 with BMS-036", bench.until(all_open, 1000), 0, 10);
  CHECK_FALSE(tripped(bench.out));
  CHECK(bench.until(tripped, 110) >= 0);
  bench.io.isolation_fault = false;
  bench.io.shutdown_closed = true;
  CHECK_FALSE(closes());
}

// BMS-036
TEST(Isolation, WhatIsShorterThanItsTimeTripsNothing) {
  bench.drive();
  for (int k = 0; k < 3; ++k) {
    bench.io.isolation_fault = true;
    bench.run(90);
    bench.io.isolation_fault = false;
    bench.run(2000);
  }
  LONGS_EQUAL(0, bench.out.faults);
  CHECK(bench.out.state == BmsState::kTsActive);
}

// BMS-036: the monitor tests itself at power-on.
TEST(Isolation, BeforeAnythingWasClosedAFaultIsWaitedForAndNotLatched) {
  bench.io.isolation_fault = true;
  bench.idle();
  bench.request(true);
  LONGS_EQUAL(-1, bench.until([](const Output& o) { return !all_open(o); }, 5000));
  LONGS_EQUAL(0, bench.out.faults);
  CHECK(bench.out.waits_for == WaitsFor::kIsolation);
  bench.io.isolation_fault = false;
  CHECK(bench.until([](const Output& o) { return o.state == BmsState::kTsActive; }, 3000) >= 0);
}

// BMS-036: long after the contactors have opened it is no trip either, and nothing closes on it.
TEST(Isolation, LongAfterTheContactorsHaveOpenedAFaultIsWaitedFor) {
  bench.drive();
  bench.request(false);
  bench.run(210);
  bench.io.isolation_fault = true;
  bench.run(1000);
  LONGS_EQUAL(0, bench.out.faults);
  CHECK(bench.out.waits_for == WaitsFor::kIsolation);
  CHECK_FALSE(closes());
  bench.io.isolation_fault = false;
  CHECK(closes());
}

// BMS-036: until when it counts as one of what was closed.
TEST(Isolation, ABitThatComesJustAfterTheOpeningTrips) {
  bench.drive();
  bench.request(false);
  bench.run(80);
  bench.io.isolation_fault = true;
  CHECK(bench.until(tripped, 300) >= 0);
}

// BMS-036: with the report lost the trip cannot be reset.
TEST(Isolation, ALostReportIsNoSoundOne) {
  bench.drive();
  bench.io.isolation_fault = true;
  bench.run(300);
  bench.silent.insert(can::VehicleIo::kId);
  bench.run(1000);
  reset();
  CHECK(tripped(bench.out));
}

// BMS-037
TEST(Isolation, AnOpenInterlockOpensInTheStepThatSeesItWhateverTheShutdownLineSays) {
  bench.drive();
  bench.io.interlock_open = true;
  expect_time("BMS-037", bench.until(all_open, 1000), 0, 10);
  CHECK(bench.out.state == BmsState::kOpen);
  LONGS_EQUAL(0, bench.out.faults);
  bench.request(false);
  bench.run(100);
  CHECK(bench.out.waits_for == WaitsFor::kInterlock);
  CHECK_FALSE(closes());
  bench.io.interlock_open = false;
  CHECK(closes());
}

// BMS-035, BMS-036, BMS-037: the most particular word first.
TEST(Isolation, WhatIsWaitedForIsTheInterlockThenTheMonitorThenTheCircuit) {
  bench.idle();
  bench.io.interlock_open = bench.io.isolation_fault = true;
  bench.io.shutdown_closed = false;
  bench.run(20);
  CHECK(bench.out.waits_for == WaitsFor::kInterlock);
  bench.io.interlock_open = false;
  bench.run(20);
  CHECK(bench.out.waits_for == WaitsFor::kIsolation);
  bench.io.isolation_fault = false;
  bench.run(20);
  CHECK(bench.out.waits_for == WaitsFor::kShutdownCircuit);
}
