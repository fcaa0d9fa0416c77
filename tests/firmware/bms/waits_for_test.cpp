// SPDX-License-Identifier: Apache-2.0
#include "bms/waits_for.hpp"

#include "bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;
using can::WaitsFor;

TEST_GROUP(WaitsFor) {
  Bench bench;
  void expect(WaitsFor what) { LONGS_EQUAL(static_cast<int>(what), static_cast<int>(bench.out.waits_for)); }
};

// BMS-035: a current that never rests, within what may be an offset.
TEST(WaitsFor, APackThatWasNeverAtRestWaitsForItsStateOfCharge) {
  bench.config.soc_start_current = Current{};
  for (int k = 0; k < 100; ++k) {
    bench.current(Current::from_raw(k % 2 == 0 ? 500 : -500));
    bench.tick();
  }
  CHECK(bench.out.current_offset_known && !bench.out.soc_valid);
  expect(WaitsFor::kSoc);
  CHECK(bench.out.state == can::BmsState::kInvalid);
}

// BMS-035
TEST(WaitsFor, AnyContactThatStaysClosedIsWaitedFor) {
  for (bool can::VehicleIo::* const contact :
       {&can::VehicleIo::air_plus_aux, &can::VehicleIo::air_minus_aux, &can::VehicleIo::precharge_aux}) {
    Bench car;
    car.drive();
    car.aux_follow_command = false;
    car.request(false);
    car.tick();
    car.io.air_plus_aux = car.io.air_minus_aux = car.io.precharge_aux = false;
    car.io.*contact = true;
    car.run(50);
    CHECK(car.out.waits_for == WaitsFor::kContactorsOpen);
    CHECK(car.out.state == can::BmsState::kOpen && all_open(car.out));
    car.io.*contact = false;
    car.run(20);
    CHECK(car.out.state == can::BmsState::kIdle);
  }
}

// BMS-035: it goes on when the request is gone, whatever hangs on the car.
TEST(WaitsFor, BeforeTheFirstRestARequestComesBeforeTheChargersSwitch) {
  bench.request(true);
  bench.io.charge_switch = true;
  bench.run(1'000);
  CHECK(bench.out.state == can::BmsState::kInvalid);
  expect(WaitsFor::kRequestReleased);
}
