// SPDX-License-Identifier: Apache-2.0
// Single rows of the fault table on a state that is made by hand, a step of 10 ms each: what they judge by, what they
// leave alone when it is not known, and how each opens.
#include "bms/faults.hpp"

#include "bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;
using can::BmsFault;
using can::BmsState;

TEST_GROUP(FaultRow) {
  Config config = pack_config();
  State state{};
  Instant now = Instant::from_ms(100'000);

  void setup() override { state = sound(); }

  template <class T>
  Sample<T> good(T value) const {
    return Sample<T>{value, now, Quality::kGood};
  }
  /// Everything is measured and as it should be; the contactors are open, and have been for a minute.
  [[nodiscard]] State sound() const {
    State s;
    s.config_ok = true;
    s.last = now;
    s.pack.cells_good = s.pack.temperatures_good = s.pack.complete_once = true;
    s.pack.oldest_cell = s.pack.oldest_temperature = now;
    s.pack.cell_sum = s.pack.sum_by_pack = PackVoltage::from_raw(936'000);
    s.measured.current = good(Current{});
    s.measured.pack_voltage = good(PackVoltage::from_raw(936'000));
    s.measured.dc_link_voltage = good(PackVoltage{});
    s.measured.io = good(VehicleIo{});
    s.measured.master = good(MasterRequest{});
    s.current_check.power_judged = true;
    s.voltage_check.steady = true;
    s.contactors.state = BmsState::kIdle;
    s.contactors.opened_at = now + Duration::from_ms(-60'000);
    return s;
  }
  void close(BmsState with) {
    state.contactors.state = with;
    state.contactors.command = {true, true, false};
    state.contactors.closed_once = true;
    state.measured.io.value.air_plus_aux = state.measured.io.value.air_minus_aux = true;
  }
  void open_again() {
    state.contactors.state = BmsState::kOpen;
    state.contactors.command = {};
    state.contactors.opened_at = now;
    state.measured.io.value.air_plus_aux = state.measured.io.value.air_minus_aux = false;
  }
  /// The next step, in which everything that is good is good again.
  void step_once() {
    now = now + Duration::from_ms(10);
    Measured& m = state.measured;
    for (Instant* time : {&m.current.time, &m.pack_voltage.time, &m.dc_link_voltage.time, &m.io.time, &m.master.time}) {
      *time = now;
    }
    judge_faults(config, now, state);
    state.last = now;
  }
  void run(std::int32_t ms) {
    for (std::int32_t t = 0; t < ms; t += 10) step_once();
  }
  [[nodiscard]] bool told(BmsFault fault) const { return is_set(state.faults, fault); }
  void reset() {
    state.measured.master.value.reset = true;
    step_once();
    state.measured.master.value.reset = false;
  }
};

TEST(FaultRow, ASoundCarHasNone) {
  run(10'000);
  LONGS_EQUAL(0, state.faults.bits);
  close(BmsState::kTsActive);
  run(10'000);
  LONGS_EQUAL(0, state.faults.bits);
  CHECK_FALSE(state.faults.open || state.faults.open_now);
}

// BMS-016: a reading that is no longer good says nothing new of the current.
TEST(FaultRow, ACurrentThatIsNotKnownIsNotTooHigh) {
  for (const double a : {700.0, -400.0}) {
    state = sound();
    state.measured.current = {amps(a), now, Quality::kStale};
    run(2'000);
    CHECK_FALSE(told(BmsFault::kDischargeCurrentHigh) || told(BmsFault::kChargeCurrentHigh));
    state.measured.current = good(amps(a));
    run(1'010);
    CHECK(told(a > 0 ? BmsFault::kDischargeCurrentHigh : BmsFault::kChargeCurrentHigh));
  }
}

// BMS-015, BMS-026: when the whole frame is lost, that of the current is told alone.
TEST(FaultRow, APackVoltageThatIsLostWithTheCurrentIsNotToldBesideIt) {
  state.measured.current.quality = state.measured.pack_voltage.quality = Quality::kStale;
  const Instant lost = now;
  for (int k = 0; k < 100; ++k) {
    now = now + Duration::from_ms(10);
    state.measured.current.time = state.measured.pack_voltage.time = lost;
    judge_faults(config, now, state);
    state.last = now;
    CHECK_EQUAL(k >= 49, told(BmsFault::kCurrentMeasurementLost));  // 500 ms after the last good one
  }
  CHECK_FALSE(told(BmsFault::kVoltageImplausible));
}

// BMS-018, BMS-019: each of three contacts, and none of which nothing is heard.
TEST(FaultRow, EachContactIsHeldAgainstItsOwnCommandWhileItIsHeard) {
  bool VehicleIo::*const contacts[] = {&VehicleIo::air_plus_aux, &VehicleIo::air_minus_aux, &VehicleIo::precharge_aux};
  bool ContactorCommand::*const commands[] = {&ContactorCommand::air_plus, &ContactorCommand::air_minus,
                                              &ContactorCommand::precharge};
  for (int k = 0; k < 3; ++k) {
    for (const bool heard : {true, false}) {
      state = sound();
      if (!heard) state.measured.io.quality = Quality::kStale;
      state.measured.io.value.*contacts[k] = true;
      run(200);
      CHECK_FALSE(told(BmsFault::kContactorWelded));
      run(10);
      CHECK_EQUAL(heard, told(BmsFault::kContactorWelded));
      CHECK_FALSE(told(BmsFault::kContactorStuckOpen));

      state = sound();
      if (!heard) state.measured.io.quality = Quality::kStale;
      state.contactors.state = BmsState::kPrecharge;
      state.contactors.command.*commands[k] = true;
      run(200);
      CHECK_FALSE(told(BmsFault::kContactorStuckOpen));
      run(10);
      CHECK_EQUAL(heard, told(BmsFault::kContactorStuckOpen));
      CHECK_FALSE(told(BmsFault::kContactorWelded));
    }
  }
}

// BMS-019: driving and charging, either main contactor.
TEST(FaultRow, AMainContactorThatFallsOpenIsToldInBothStatesInWhichItCarriesCurrent) {
  for (const BmsState with : {BmsState::kTsActive, BmsState::kCharging}) {
    for (const bool plus : {true, false}) {
      for (const bool heard : {true, false}) {
        state = sound();
        close(with);
        run(50);
        (plus ? state.measured.io.value.air_plus_aux : state.measured.io.value.air_minus_aux) = false;
        if (!heard) state.measured.io.quality = Quality::kStale;
        run(20);
        CHECK_FALSE(told(BmsFault::kContactorStuckOpen));
        run(10);
        CHECK_EQUAL(heard, told(BmsFault::kContactorStuckOpen));
      }
    }
  }
}

// BMS-018: above 60 V or half of the pack, from 5 s after the opening on, as long as both are measured.
TEST(FaultRow, ADcLinkIsConnectedBeyondItsBoundsAndNotAtThem) {
  const auto connected = [this](std::int32_t link, std::int32_t pack) {
    state = sound();
    state.measured.dc_link_voltage.value = PackVoltage::from_raw(link);
    state.measured.pack_voltage.value = PackVoltage::from_raw(pack);
    step_once();
    return told(BmsFault::kContactorWelded);
  };
  CHECK_FALSE(connected(600'000, 3'000'000));
  CHECK(connected(600'001, 3'000'000));
  CHECK_FALSE(connected(200'000, 400'000));
  CHECK(connected(200'001, 400'000));

  state = sound();
  state.contactors.opened_at = now;
  state.measured.dc_link_voltage.value = PackVoltage::from_raw(936'000);
  run(4'990);
  CHECK_FALSE(told(BmsFault::kContactorWelded));
  step_once();
  CHECK(told(BmsFault::kContactorWelded));

  for (const bool link : {true, false}) {
    state = sound();
    state.measured.dc_link_voltage.value = PackVoltage::from_raw(936'000);
    (link ? state.measured.dc_link_voltage : state.measured.pack_voltage).quality = Quality::kStale;
    step_once();
    CHECK_FALSE(told(BmsFault::kContactorWelded));
  }
}

// BMS-036: what counts as just opened is twice the time of the fault, to the millisecond.
TEST(FaultRow, AnIsolationFaultCountsUntilTwiceItsTimeAfterTheOpening) {
  const auto first_heard_after = [this](std::int32_t ms, Quality quality) {
    state = sound();
    close(BmsState::kTsActive);
    step_once();
    open_again();
    run(ms - 10);
    state.measured.io.value.isolation_fault = true;
    state.measured.io.quality = quality;
    run(10);
    return state.faults.timer[13].active;
  };
  CHECK(first_heard_after(200, Quality::kGood));
  CHECK_FALSE(first_heard_after(210, Quality::kGood));
  CHECK_FALSE(first_heard_after(100, Quality::kStale));
}

// BMS-023, BMS-036: once it has tripped it cannot be reset before it has gone, however long nothing was closed.
TEST(FaultRow, AnIsolationFaultThatIsStillThereIsNotReset) {
  close(BmsState::kTsActive);
  state.measured.io.value.isolation_fault = true;
  run(110);
  CHECK(told(BmsFault::kIsolationFault));
  open_again();
  run(10'000);
  reset();
  CHECK(told(BmsFault::kIsolationFault));
  state.measured.io.value.isolation_fault = false;
  step_once();
  reset();
  CHECK_FALSE(told(BmsFault::kIsolationFault));
}

// BMS-022: cells and pack are held against each other while both are known.
TEST(FaultRow, VoltagesDisagreeOnlyWhereBothAreKnown) {
  config.measurement_lost_time = Duration::from_ms(5'000);
  for (const bool cells : {true, false}) {
    for (const bool pack : {true, false}) {
      state = sound();
      state.voltage_check.lasting = true;
      state.pack.sum_by_pack = PackVoltage::from_raw(836'000);
      state.pack.cells_good = cells;
      state.measured.pack_voltage.quality = pack ? Quality::kGood : Quality::kInvalid;
      run(1'000);
      CHECK_FALSE(told(BmsFault::kVoltageImplausible));
      run(10);
      CHECK_EQUAL(cells && pack, told(BmsFault::kVoltageImplausible));
    }
  }
}

// BMS-067
TEST(FaultRow, APowerThatIsNotJudgedHoldsWhatWasFound) {
  state.current_check.power_wrong = true;
  state.current_check.power_judged = false;
  run(3'000);
  CHECK_FALSE(told(BmsFault::kCurrentImplausible));
  state.current_check.power_judged = true;
  run(600);
  state.current_check.power_judged = false;
  run(3'000);
  CHECK_FALSE(told(BmsFault::kCurrentImplausible));
  state.current_check.power_judged = true;
  run(410);
  CHECK(told(BmsFault::kCurrentImplausible));
}

// BMS-023: a request that is new, heard, and made with everything open.
TEST(FaultRow, AResetIsANewRequestOfAMasterThatIsHeardWithTheTractiveSystemOff) {
  const auto latched_after = [this](const std::function<void()>& ask) {
    state = sound();
    state.contactors.precharge_failed = true;
    step_once();
    state.contactors.precharge_failed = false;
    step_once();
    CHECK(told(BmsFault::kPrechargeTimeout) && state.faults.open_now);
    ask();
    return state.faults.latched != 0;
  };
  MasterRequest& master = state.measured.master.value;
  Quality& heard = state.measured.master.quality;
  CHECK_FALSE(latched_after([&] { reset(); }));
  CHECK(latched_after([&] {
    heard = Quality::kStale;
    reset();
  }));
  CHECK(latched_after([&] {
    master.reset = true;
    heard = Quality::kStale;
    step_once();
    heard = Quality::kGood;  // was it held meanwhile?
    step_once();
  }));
  CHECK(latched_after([&] {
    heard = Quality::kStale;
    step_once();
    heard = Quality::kGood;
    reset();
  }));
  CHECK(latched_after([&] {
    master.tractive_system = true;
    reset();
  }));
  CHECK(latched_after([&] {
    state.contactors.command.air_minus = state.measured.io.value.air_minus_aux = true;
    reset();
  }));
}

// BMS-023, BMS-024: with the reset everything that was counted is forgotten, and told no more in the same step.
TEST(FaultRow, WhatIsResetIsForgottenInTheSameStep) {
  state.measured.current.value = amps(601);
  run(1'010);
  CHECK(told(BmsFault::kDischargeCurrentHigh));
  state.measured.current.value = amps(0);
  step_once();
  reset();
  LONGS_EQUAL(0, state.faults.bits);
  LONGS_EQUAL(0, state.faults.latched);
  run(100);
  LONGS_EQUAL(0, state.faults.bits);
  state.measured.current.value = amps(601);
  run(1'000);
  LONGS_EQUAL(0, state.faults.bits);
}

// BMS-023: before the first complete set there is nothing to be reset, and what is told goes on.
TEST(FaultRow, AResetBeforeTheFirstCompleteSetClearsNothing) {
  state.contactors.state = BmsState::kInvalid;
  state.voltage_check.cell_missing = true;
  run(1'010);
  CHECK(told(BmsFault::kVoltageImplausible));
  state.voltage_check.steady = false;  // nothing can be said now
  reset();
  CHECK(told(BmsFault::kVoltageImplausible));
  LONGS_EQUAL(0, state.faults.latched);
}

// BMS-011, BMS-012: of no cell and no sensor the extremes mean nothing.
TEST(FaultRow, WithoutASingleOneThereIsNoHighestCellNorHottestSensor) {
  state.pack.cells_good = state.pack.temperatures_good = false;
  state.pack.cell_max = CellVoltage::from_raw(45'000);
  state.pack.temperature_max = Temperature::from_raw(900);
  state.pack.weakest_cell = state.pack.hottest_sensor = kNoCell;
  run(2'000);
  CHECK_FALSE(told(BmsFault::kCellVoltageHigh) || told(BmsFault::kTemperatureHigh));
  state.pack.weakest_cell = state.pack.hottest_sensor = 0;
  run(2'000);
  CHECK(told(BmsFault::kCellVoltageHigh) && told(BmsFault::kTemperatureHigh));
}

// BMS-014: a reading that is good is not lost, however seldom it comes.
TEST(FaultRow, WhatIsGoodAgainIsNotLostByItsAge) {
  config.measurement_lost_time = Duration::from_ms(300);
  state.pack.temperatures_good = false;
  state.pack.oldest_temperature = now;
  run(200);
  state.pack.temperatures_good = true;
  run(400);
  CHECK_FALSE(told(BmsFault::kTemperatureMeasurementLost));
}

// BMS-017 to BMS-021, BMS-034: what cannot wait for the torque, what waits, and what opens nothing.
TEST(FaultRow, EachOpensAsItsRowSays) {
  const auto check_opens = [this](BmsFault fault, bool open, bool now_at_once) {
    CHECK(told(fault));
    CHECK_EQUAL(open, state.faults.open);
    CHECK_EQUAL(now_at_once, state.faults.open_now);
    state = sound();
  };
  state.contactors.precharge_failed = true;
  step_once();
  check_opens(BmsFault::kPrechargeTimeout, true, true);
  state.config_ok = false;
  step_once();
  check_opens(BmsFault::kConfigInvalid, true, true);
  state.measured.io.quality = Quality::kStale;
  step_once();
  check_opens(BmsFault::kVehicleIoLost, true, true);
  state.measured.master.quality = Quality::kStale;
  step_once();
  check_opens(BmsFault::kMasterLost, true, false);
  state.measured.dc_link_voltage.quality = Quality::kStale;
  step_once();
  check_opens(BmsFault::kInverterLost, false, false);
  state.measured.current.value = amps(601);
  run(1'010);
  check_opens(BmsFault::kDischargeCurrentHigh, true, false);
}
