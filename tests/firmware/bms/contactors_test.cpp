// SPDX-License-Identifier: Apache-2.0
#include "bms/contactors.hpp"

#include "bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;
using can::BmsState;

namespace {
bool opened(const Output& o) { return all_open(o); }
bool active(const Output& o) { return o.state == BmsState::kTsActive; }
}  // namespace

TEST_GROUP(Contactor) {
  Bench bench;
};

TEST(Contactor, SequenceClosesAirMinusAndPrechargeThenAirPlusThenDropsPrecharge) {
  bench.idle();
  CHECK(bench.out.state == BmsState::kIdle);
  bench.request(true);
  bench.tick();
  CHECK(bench.out.state == BmsState::kPrecharge);
  CHECK(bench.out.contactors.air_minus && bench.out.contactors.precharge && !bench.out.contactors.air_plus);
  bool precharge_held = true;
  bench.until([&](const Output& o) {
    if (o.contactors.air_plus && !active(o)) precharge_held = precharge_held && o.contactors.precharge;
    return active(o);
  });
  CHECK_TEXT(precharge_held, "precharge stays closed until AIR+ has closed");
  CHECK(bench.out.contactors.air_plus && bench.out.contactors.air_minus && !bench.out.contactors.precharge);
}

TEST(Contactor, AirPlusThatDoesNotCloseNeverBecomesActive) {
  bench.idle();
  bench.request(true);
  bench.tick();
  bench.until([](const Output& o) { return o.contactors.air_plus; });
  bench.aux_follow_command = false;
  bench.io.air_plus_aux = false;
  bool was_active = false;
  const auto watch = [&](const Output& o) {
    was_active = was_active || active(o);
    return opened(o);
  };
  CHECK(bench.until(watch, 1000) > 0);
  CHECK_FALSE(was_active);
  CHECK(has(bench.out, can::BmsFault::kContactorStuckOpen));
}

// BMS-031
TEST(Contactor, AirPlusClosesAtThePrechargeRatioAndNotAFewLsbBelow) {
  const std::int32_t pack = 24 * 39'000;  // 93.60 V: 95 % are 88.92 V
  const std::int32_t ratio = pack / 100 * 95;
  for (std::int32_t below : {100, 200, 300}) {
    Bench b;
    b.link_follows = false;
    b.idle();
    b.request(true);
    b.inverter.dc_link_voltage_100uv = ratio - below;  // one step of 10 mV and more below
    LONGS_EQUAL(-1, b.until([](const Output& o) { return o.contactors.air_plus; }, 4000));
  }
  for (std::int32_t above : {0, 100, 300}) {
    Bench b;
    b.link_follows = false;
    b.idle();
    b.request(true);
    b.run(100);
    b.inverter.dc_link_voltage_100uv = ratio + above;
    expect_time("BMS-031", b.until([](const Output& o) { return o.contactors.air_plus; }, 1000), 0, 10);
  }
}

// BMS-017
TEST(Contactor, PrechargeThatIsTooSlowIsGivenUpAndLatched) {
  bench.idle();
  bench.link_follows = false;
  bench.request(true);
  bench.tick();
  expect_time("BMS-017", bench.until(opened), 4990, 5000);
  bench.tick();
  CHECK(has(bench.out, can::BmsFault::kPrechargeTimeout));
  bench.run(2000);
  CHECK(has(bench.out, can::BmsFault::kPrechargeTimeout));
}

TEST(Contactor, PrechargeWaitsForAMeasuredDcLinkVoltage) {
  bench.idle();
  bench.request(true);
  bench.tick();
  bench.silent.insert(can::InverterStatus::kId);
  CHECK(bench.until(opened) >= 4900);
}

// BMS-018
TEST(Contactor, ContactsThatTravelDoNotHideAWeldedAirPlus) {
  bench.idle();
  bench.link_follows = false;
  bench.request(true);
  bench.aux_follow_command = false;
  bench.tick();
  bench.run(50);  // longer than precharge_time_min
  CHECK(bench.out.state == BmsState::kPrecharge);
  bench.io.air_minus_aux = bench.io.precharge_aux = true;
  bench.inverter.dc_link_voltage_100uv = 24 * 39'000;
  const auto told = [](const Output& o) { return has(o, can::BmsFault::kContactorWelded); };
  expect_time("BMS-018 travel", bench.until(told, 1000), 0, 20);
  CHECK(!bench.out.contactors.air_minus && !bench.out.contactors.precharge);
}

// BMS-018
TEST(Contactor, DcLinkThatIsUpInNoTimeMeansAWeldedAirPlus) {
  bench.idle();
  bench.request(true);
  bench.tick();
  bench.inverter.dc_link_voltage_100uv = 24 * 39'000;
  expect_time("BMS-018 precharge", bench.until(opened), 0, 10);
  bench.tick();
  CHECK(has(bench.out, can::BmsFault::kContactorWelded));
}

TEST(Contactor, DcLinkStillChargedFromBeforeIsNoWeld) {
  bench.drive();
  bench.request(false);
  bench.run(50);
  bench.request(true);
  CHECK(bench.until(active, 3000) >= 0);
  LONGS_EQUAL(0, bench.out.faults);
}

// BMS-030
TEST(Contactor, OpenShutdownCircuitOpensInTheStepThatSeesIt) {
  bench.drive();
  bench.io.shutdown_closed = false;
  expect_time("BMS-030 shutdown", bench.until(opened), 0, 10);
  CHECK(bench.out.state == BmsState::kOpen);
}

TEST(Contactor, WithdrawnRequestOpensInTheStepThatSeesIt) {
  bench.drive();
  bench.request(false);
  expect_time("BMS-030 request", bench.until(opened), 0, 10);
}

TEST(Contactor, TripOpensInTheStepThatSetsIt) {
  bench.drive();
  bench.cell_100uv[0] = 20'000;
  bench.until([](const Output& o) { return o.faults != 0; });
  CHECK(all_open(bench.out));
  LONGS_EQUAL(static_cast<int>(BmsState::kFault), static_cast<int>(bench.out.state));
}

TEST(Contactor, StandingRequestDoesNotCloseAgainAfterTheShutdownCircuitClosed) {
  bench.drive();
  bench.io.shutdown_closed = false;
  bench.run(100);
  bench.io.shutdown_closed = true;
  bench.run(1000);
  CHECK(all_open(bench.out));
  bench.request(false);
  bench.run(100);
  bench.request(true);
  CHECK(bench.until(active, 3000) >= 0);
}

TEST(Contactor, NothingClosesWhileTheShutdownCircuitIsOpen) {
  bench.io.shutdown_closed = false;
  bench.idle();
  bench.request(true);
  LONGS_EQUAL(-1, bench.until([](const Output& o) { return !all_open(o); }, 2000));
}

TEST(Contactor, NothingClosesWithACellMissing) {
  bench.idle();
  bench.invalid_cells.insert(3);
  bench.run(40);
  bench.request(true);
  LONGS_EQUAL(-1, bench.until([](const Output& o) { return !all_open(o); }, 2000));
}

TEST(Contactor, RequestThatStandsFromTheStartClosesNothing) {
  bench.request(true);
  LONGS_EQUAL(-1, bench.until([](const Output& o) { return !all_open(o); }, 3000));
}

TEST(Contactor, AllZeroMasterFrameIsNoRequest) {
  bench.idle();
  bench.master = can::MasterStatus{};
  bench.master.ts_request = true;  // with the drive state that means invalid
  LONGS_EQUAL(-1, bench.until([](const Output& o) { return !all_open(o); }, 2000));
}

TEST(Contactor, AllZeroMemoryIsInvalidWithEverythingOpen) {
  const State state{};
  CHECK(state.contactors.state == BmsState::kInvalid);
  CHECK(!state.contactors.command.air_plus && !state.contactors.command.air_minus);
}

namespace {

bool waits(const Output& o, can::WaitsFor what) { return o.waits_for == what; }

/// On and off again, as long as the precharge resistor lets it: how often.
int close_again_and_again(Bench& bench, std::uint32_t ms) {
  int closed = 0;
  for (std::uint32_t end = bench.now_ms + ms; bench.now_ms < end;) {
    bench.request(true);
    if (bench.until(active, 3000) >= 0) ++closed;
    bench.request(false);
    bench.run(100);
  }
  return closed;
}

}  // namespace

// BMS-032
TEST(Contactor, DcLinkSensorThatIsStuckHighFromPowerOnSkipsNoPrecharge) {
  bench.link_follows = false;
  bench.inverter.dc_link_voltage_100uv = 24 * 39'000;
  bench.idle();
  bench.request(true);
  bench.tick();
  CHECK(opened(bench.out));
  CHECK(waits(bench.out, can::WaitsFor::kDcLinkDischarged));
  std::int32_t took = 510;
  while (!has(bench.tick(), can::BmsFault::kContactorWelded) && took < 9000) {
    CHECK(opened(bench.out));
    took += 10;
  }
  expect_time("BMS-032, since power-on", took, 5000, 5020);
}

// BMS-032
TEST(Contactor, DcLinkThatWasUpBeforeIsPrechargedForItsTime) {
  bench.drive();
  bench.request(false);
  bench.run(50);
  bench.link_follows = false;  // a sensor that stands where it was
  bench.request(true);
  const std::int32_t took = bench.until([](const Output& o) { return o.contactors.air_plus; }, 9000);
  expect_time("BMS-032 unseen", took, 2000, 2020);
}

// BMS-018
TEST(Contactor, DcLinkAboveSixtyVoltsFiveSecondsAfterOpeningTrips) {
  Config big = pack_config();
  big.cells_in_series = 120;
  big.temperature_sensors = 30;
  for (const std::int32_t volts : {59, 61}) {
    Bench b(big);
    b.drive();
    b.request(false);
    b.run(50);
    b.link_follows = false;
    b.inverter.dc_link_voltage_100uv = volts * 10'000;  // of 468 V: far below half
    const std::int32_t took = b.until([](const Output& o) { return has(o, can::BmsFault::kContactorWelded); }, 8000);
    if (volts < 60) LONGS_EQUAL(-1, took);
    if (volts > 60) expect_time("BMS-018 60 V, after opening", took + 50, 5000, 5010);
  }
}

// BMS-033
TEST(Contactor, PrechargesAreLimitedAndTheResistorCools) {
  bench.idle();
  LONGS_EQUAL(4, close_again_and_again(bench, 5'000) > 4 ? 5 : 4);
  bench.request(true);
  CHECK(bench.until(active, 3000) < 0 || bench.now_ms > 10'000);
  const int in_a_minute = close_again_and_again(bench, 60'000);
  std::printf("BMS-033: %d closings in 60 s (bound 8)\n", in_a_minute);
  CHECK(in_a_minute >= 5 && in_a_minute <= 8);
}

// BMS-033, BMS-035
TEST(Contactor, FifthPrechargeInARowWaitsForItsCooling) {
  bench.idle();
  for (int i = 0; i < 4; ++i) {
    bench.request(true);
    bench.tick();
    bench.request(false);
    bench.run(50);
  }
  const std::uint32_t first_ms = 500;
  bench.request(true);
  bench.run(50);
  CHECK(opened(bench.out));
  CHECK(waits(bench.out, can::WaitsFor::kPrechargeCooled));
  CHECK(bench.until([](const Output& o) { return !all_open(o); }, 20'000) > 0);
  expect_time("BMS-033, since the first", static_cast<std::int32_t>(bench.now_ms - first_ms), 10'000, 10'030);
}

// BMS-034
TEST(Contactor, ContactorsFollowTheTorqueAndOpenWithinAHundredMilliseconds) {
  bench.drive();
  bench.current(amps(369));
  bench.run(20);
  bench.request(false);
  bench.tick();
  CHECK_FALSE(opened(bench.out));
  LONGS_EQUAL(0, bench.out.limits.discharge.value.raw());
  CHECK(bench.out.state == BmsState::kOpen);
  bench.run(20);
  bench.current(amps(20));
  expect_time("BMS-034 when the current has gone", bench.until(opened, 500), 0, 10);
}

// BMS-034
TEST(Contactor, CurrentThatDoesNotGoIsOpenedAfterAHundredMilliseconds) {
  bench.drive();
  bench.current(amps(-200));
  bench.run(20);
  bench.cell_100uv[0] = 20'000;
  bench.until([](const Output& o) { return o.faults != 0; });
  CHECK_FALSE(opened(bench.out));
  LONGS_EQUAL(0, bench.out.limits.charge.value.raw());
  CHECK(bench.out.state == BmsState::kFault);
  expect_time("BMS-034 at most", 10 + bench.until(opened, 500), 90, 100);
  bench.run(100);
  CHECK(bench.out.state == BmsState::kFault);
}

// BMS-030
TEST(Contactor, WhatTheRuleDemandsAtOnceDoesNotWaitForTheCurrent) {
  for (int what = 0; what < 3; ++what) {
    Bench b;
    b.drive();
    b.current(amps(369));
    b.run(20);
    if (what == 0) b.io.shutdown_closed = false;
    if (what == 1) b.silent.insert(can::VehicleIo::kId);
    if (what == 2) b.request(false);
    b.run(20);
    if (what == 2) {
      CHECK_FALSE(opened(b.out));
      b.io.shutdown_closed = false;  // in the middle of waiting
    }
    expect_time("BMS-030 at 369 A", b.until(opened, 500), 0, what == 1 ? 90 : 10);
  }
}

// BMS-035
TEST(Contactor, NotReadySaysWhatIsMissing) {
  const struct {
    can::WaitsFor reason;
    void (*miss)(Bench&);
  } kRows[] = {
      {can::WaitsFor::kCells, [](Bench& b) { b.invalid_cells.insert(3); }},
      {can::WaitsFor::kTemperatures, [](Bench& b) { b.silent.insert(0x240); }},
      {can::WaitsFor::kCurrent, [](Bench& b) { b.pack.pack_current_ok = false; }},
      {can::WaitsFor::kPackVoltage, [](Bench& b) { b.pack.pack_voltage_ok = false; }},
      {can::WaitsFor::kVehicleIo, [](Bench& b) { b.silent.insert(can::VehicleIo::kId); }},
      {can::WaitsFor::kCurrentOffset, [](Bench& b) { b.current(amps(9)); }},
      {can::WaitsFor::kMaster, [](Bench& b) { b.silent.insert(can::MasterStatus::kId); }},
      {can::WaitsFor::kRequestReleased, [](Bench& b) { b.request(true); }},
  };
  for (const auto& row : kRows) {
    Bench b;
    row.miss(b);
    b.run(1000);
    LONGS_EQUAL(static_cast<int>(row.reason), static_cast<int>(b.out.waits_for));
    CHECK(opened(b.out));
  }
  Config none = pack_config();
  none.capacity_mah = 0;
  CHECK(waits(Bench(none).run(100), can::WaitsFor::kConfiguration));
}

// BMS-035
TEST(Contactor, IdleSaysWhatARequestWouldWaitFor) {
  bench.idle();
  CHECK(waits(bench.out, can::WaitsFor::kNone));
  bench.io.shutdown_closed = false;
  CHECK(waits(bench.tick(), can::WaitsFor::kShutdownCircuit));
  bench.io.shutdown_closed = true;
  bench.silent.insert(can::InverterStatus::kId);
  CHECK(waits(bench.run(200), can::WaitsFor::kDcLinkVoltage));
  bench.silent.clear();
  bench.cell_100uv[0] = 20'000;
  CHECK(waits(bench.run(800), can::WaitsFor::kFaultGone));
}

TEST(Contactor, OpenSaysThatTheRequestOrAContactStands) {
  bench.drive();
  CHECK(waits(bench.out, can::WaitsFor::kNone));
  bench.io.shutdown_closed = false;
  bench.run(20);
  CHECK(waits(bench.out, can::WaitsFor::kRequestReleased));
  bench.aux_follow_command = false;
  bench.io.air_plus_aux = true;
  bench.request(false);
  CHECK(waits(bench.run(50), can::WaitsFor::kContactorsOpen));
}
