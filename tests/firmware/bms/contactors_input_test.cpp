// SPDX-License-Identifier: Apache-2.0
// The sequence of the contactors with each thing missing that it goes by.
#include "bms/contactors.hpp"

#include "bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;
using can::BmsState;

namespace {

bool active(const Output& o) { return o.state == BmsState::kTsActive; }
void lose(Quality& quality) { quality = Quality::kStale; }

}  // namespace

TEST_GROUP(ContactorInput) {
  Bench bench;

  /// One step of the sequence alone, whatever ingest and faults say.
  BmsState sequence() {
    sequence_contactors(bench.config, bench.now(), bench.state);
    return bench.state.contactors.state;
  }
  [[nodiscard]] bool closed() const { return commanded(bench.state.contactors.command); }
};

// BMS-031
TEST(ContactorInput, NothingClosesWithoutAnyOfItsMeasurements) {
  bench.idle();
  bench.state.measured.master.value.tractive_system = true;
  const State ready = bench.state;
  CHECK(sequence() == BmsState::kPrecharge && closed());
  void (*const missing[])(State&) = {
      [](State& s) { s.pack.cells_good = false; },
      [](State& s) { s.pack.temperatures_good = false; },
      [](State& s) { lose(s.measured.current.quality); },
      [](State& s) { lose(s.measured.pack_voltage.quality); },
      [](State& s) { s.soc.valid = false; },
      [](State& s) { lose(s.measured.dc_link_voltage.quality); },
      [](State& s) { lose(s.measured.io.quality); },
      [](State& s) { lose(s.measured.master.quality); },
  };
  for (const auto& miss : missing) {
    bench.state = ready;
    miss(bench.state);
    CHECK(sequence() == BmsState::kIdle && !closed());
  }
}

// BMS-021, BMS-030
TEST(ContactorInput, ARequestOrAShutdownCircuitThatIsNotKnownOpensThemAll) {
  for (const bool master : {false, true}) {
    Bench car;
    car.drive();
    lose(master ? car.state.measured.master.quality : car.state.measured.io.quality);
    sequence_contactors(car.config, car.now(), car.state);
    CHECK(car.state.contactors.state == BmsState::kOpen);
    CHECK_FALSE(commanded(car.state.contactors.command));
  }
}

// BMS-031
TEST(ContactorInput, APackVoltageOfNothingOrNoneIsNoRatioToClose) {
  for (const bool lost : {false, true}) {
    Bench car;
    car.idle();
    car.request(true);
    car.run(60);
    CHECK(car.out.state == BmsState::kPrecharge && !car.out.contactors.air_plus);
    car.sum_follows_cells = false;
    car.pack.pack_voltage_100uv = lost ? 24 * 39'000 : 0;
    car.pack.pack_voltage_ok = !lost;
    LONGS_EQUAL(-1, car.until([](const Output& o) { return o.contactors.air_plus; }, 6'000));
  }
}

// BMS-018: the fault of the contact is told, and not hidden behind an offset that cannot be learned.
TEST(ContactorInput, AContactThatIsClosedAtPowerOnIsToldAsAWeld) {
  bench.aux_follow_command = false;
  bench.io.air_plus_aux = true;
  const auto told = [](const Output& o) { return has(o, can::BmsFault::kContactorWelded); };
  CHECK(bench.until([&](const Output& o) { return told(o) && o.state == BmsState::kFault; }, 1'000) >= 0);
  CHECK_FALSE(bench.out.current_offset_known);
  bench.io.air_plus_aux = false;
  bench.run(1'000);
  CHECK(told(bench.out) && all_open(bench.out));
}

// BMS-018
TEST(ContactorInput, ThePathIsClosedWhenTheLastOfBothContactsIs) {
  bench.idle();
  bench.link_follows = false;
  bench.request(true);
  bench.aux_follow_command = false;
  bench.tick();
  bench.io.air_minus_aux = true;
  bench.run(50);
  bench.io.precharge_aux = true;
  bench.inverter.dc_link_voltage_100uv = 24 * 39'000;  // with the second one: through no resistor
  const auto told = [](const Output& o) { return has(o, can::BmsFault::kContactorWelded); };
  expect_time("BMS-018 second contact", bench.until(told, 1'000), 0, 20);
}

// BMS-032: of 60 % nobody saw the rise, so it has the time in which it rises, and no less.
TEST(ContactorInput, APrechargeThatWasNotSeenToBeginFailsAfterTheLongerTime) {
  bench.config.precharge_timeout = Duration::from_ms(500);
  bench.drive();
  bench.request(false);
  bench.run(50);
  bench.link_follows = false;
  bench.inverter.dc_link_voltage_100uv = 24 * 39'000 / 10 * 6;
  bench.request(true);
  bench.tick();
  CHECK(bench.out.state == BmsState::kPrecharge);
  const auto failed = [](const Output& o) { return has(o, can::BmsFault::kPrechargeTimeout); };
  expect_time("BMS-032 fails", bench.until(failed, 9'000), 1'990, 2'010);
}

// BMS-034
TEST(ContactorInput, AFaultThatIsGoneBeforeTheCurrentOpensNothingSooner) {
  bench.drive();
  bench.current(amps(369));
  bench.run(20);
  bench.silent.insert(can::MasterStatus::kId);
  CHECK(bench.until([](const Output& o) { return o.state == BmsState::kFault; }, 200) >= 0);
  bench.silent.clear();
  bench.run(30);
  CHECK(bench.out.faults == 0 && bench.out.state == BmsState::kFault);
  CHECK(bench.out.contactors.air_plus && bench.out.contactors.air_minus);
  LONGS_EQUAL(0, bench.out.limits.discharge.value.raw());
  expect_time("BMS-034 fault gone", 30 + bench.until(all_open, 500), 90, 100);
  bench.run(20);
  CHECK(bench.out.state == BmsState::kOpen);
}

// BMS-034
TEST(ContactorInput, AFaultInTheMiddleOfAnOpeningGivesItNoNewTime) {
  bench.drive();
  bench.current(amps(369));
  bench.run(20);
  bench.cell_100uv[0] = 20'000;
  bench.run(460);
  CHECK(active(bench.out));
  bench.request(false);
  bench.tick();
  CHECK(bench.out.state == BmsState::kOpen && bench.out.contactors.air_plus);
  std::int32_t took = 0;
  bool fault_before = false;
  for (; !all_open(bench.tick()) && took < 500; took += 10) fault_before = fault_before || bench.out.faults != 0;
  CHECK(fault_before && bench.out.state == BmsState::kFault);
  expect_time("BMS-034 since the request has gone", 10 + took, 90, 100);
}

// BMS-018: a contact that nobody reads may be welded.
TEST(ContactorInput, NothingIsIdleBeforeTheContactsAreKnownToBeOpen) {
  bench.drive();
  bench.io.shutdown_closed = false;
  bench.run(50);
  bench.state.measured.master.value.tractive_system = false;
  const State open = bench.state;
  CHECK(open.contactors.state == BmsState::kOpen);
  lose(bench.state.measured.io.quality);
  CHECK(sequence() == BmsState::kOpen);
  bench.state = open;
  CHECK(sequence() == BmsState::kIdle);
}
