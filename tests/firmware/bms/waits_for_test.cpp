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

namespace {

/// Everything is there and open: nothing is waited for but a request.
State ready(can::BmsState in) {
  State s;
  s.contactors.state = in;
  s.pack.cells_good = s.pack.temperatures_good = s.current_check.offset_known = s.soc.valid = true;
  Measured& m = s.measured;
  for (Quality* q : {&m.current.quality, &m.pack_voltage.quality, &m.io.quality, &m.master.quality,
                     &m.dc_link_voltage.quality}) {
    *q = Quality::kGood;
  }
  m.io.value.shutdown_closed = true;
  m.pack_voltage.value = PackVoltage::from_raw(1'000'000);
  return s;
}

}  // namespace

TEST_GROUP(WaitsForState) {
  Config config = pack_config();
  void expect(WaitsFor what, const State& s) {
    LONGS_EQUAL(static_cast<int>(what), static_cast<int>(waits_for(config, s)));
  }
};

// BMS-035
TEST(WaitsForState, WithEverythingThereNothingIsWaitedFor) {
  for (const can::BmsState in : {can::BmsState::kIdle, can::BmsState::kInvalid, can::BmsState::kOpen}) {
    State s = ready(in);
    expect(WaitsFor::kNone, s);
    s.current_check.offset_known = false;
    expect(in == can::BmsState::kInvalid ? WaitsFor::kCurrentOffset : WaitsFor::kNone, s);
  }
}

// BMS-035: contactors that are closed, or about to, wait for nothing, whatever has just been lost.
TEST(WaitsForState, AClosedPathWaitsForNothing) {
  for (const can::BmsState in : {can::BmsState::kPrecharge, can::BmsState::kTsActive, can::BmsState::kCharging}) {
    State s = ready(in);
    s.faults.open = true;
    s.pack.cells_good = false;
    expect(WaitsFor::kNone, s);
    s.contactors.state = can::BmsState::kIdle;
    expect(WaitsFor::kFaultGone, s);
    s.faults.open = false;
    expect(WaitsFor::kCells, s);
  }
}

// BMS-035: a link that nobody has charged, at or above its share of the pack's voltage.
TEST(WaitsForState, AChargedDcLinkIsWaitedForUntilTheContactorsHaveBeenClosedOnce) {
  State s = ready(can::BmsState::kIdle);
  config.dc_link_welded = Ratio::from_raw(500'000);
  for (const std::int32_t link : {499'999, 500'000}) {
    s.measured.dc_link_voltage.value = PackVoltage::from_raw(link);
    s.contactors.closed_once = false;
    expect(link == 500'000 ? WaitsFor::kDcLinkDischarged : WaitsFor::kNone, s);
    s.contactors.closed_once = true;
    expect(WaitsFor::kNone, s);
  }
}

namespace {

void expect_suspect(const State& s, can::SuspectWhy why, std::uint8_t index = kNoCell) {
  const Suspect found = find_suspect(s);
  LONGS_EQUAL(static_cast<int>(why), static_cast<int>(found.why));
  LONGS_EQUAL(index, found.index);
}

}  // namespace

TEST(WaitsForState, OnlyAPowerThatWasJudgedIsSuspect) {
  State s;
  expect_suspect(s, can::SuspectWhy::kNone);
  s.current_check.power_wrong = true;
  expect_suspect(s, can::SuspectWhy::kNone);
  s.current_check.power_judged = true;
  expect_suspect(s, can::SuspectWhy::kPower);
  s.current_check.power_wrong = false;
  expect_suspect(s, can::SuspectWhy::kNone);
  s.current_check.offset_too_large = true;
  expect_suspect(s, can::SuspectWhy::kOffset);
}

// BMS-058
TEST(WaitsForState, TheFarthestCellIsSuspectWhereAChargeEndedForWhatBalancingWasGivenUpFor) {
  State s;
  s.charge.off_cell = 7;
  s.charge.reason = s.charge.last = can::ChargeReason::kUneven;
  expect_suspect(s, can::SuspectWhy::kNone);
  s.charge.phase = can::ChargePhase::kFull;
  expect_suspect(s, can::SuspectWhy::kNone);
  s.charge.phase = can::ChargePhase::kStopped;
  expect_suspect(s, can::SuspectWhy::kUneven, 7);
  s.charge.reason = can::ChargeReason::kFault;
  expect_suspect(s, can::SuspectWhy::kNone);
}
