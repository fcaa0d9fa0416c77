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
