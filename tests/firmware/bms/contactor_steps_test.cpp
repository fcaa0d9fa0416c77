// SPDX-License-Identifier: Apache-2.0
// Single steps of the contactors' sequence on a state that is made by hand, with every bound to the millisecond.
#include "bms/contactors.hpp"

#include "bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;
using can::BmsState;

TEST_GROUP(ContactorStep) {
  Config config = pack_config();
  State state{};
  Instant now = Instant::from_ms(100'000);
  Contactors& c = state.contactors;
  Measured& m = state.measured;

  void setup() override { sound(); }

  template <class T>
  Sample<T> good(T value) const {
    return Sample<T>{value, now, Quality::kGood};
  }
  /// Idle, everything is measured, the master wants the tractive system.
  void sound() {
    state = State{};
    state.soc.valid = true;
    state.pack.cells_good = state.pack.temperatures_good = state.pack.complete_once = true;
    state.current_check.offset_known = true;
    m.current = good(Current{});
    m.pack_voltage = good(PackVoltage::from_raw(1'000'000));
    m.dc_link_voltage = good(PackVoltage{});
    VehicleIo io;
    io.shutdown_closed = true;
    m.io = good(io);
    m.master = good(MasterRequest{true, false});
    c.state = BmsState::kIdle;
  }
  void after(std::int32_t ms) {
    now = now + Duration::from_ms(ms);
    sequence_contactors(config, now, state);
  }
  void link(std::int32_t v_100uv) { m.dc_link_voltage.value = PackVoltage::from_raw(v_100uv); }
  void path(bool minus, bool relay) {
    m.io.value.air_minus_aux = minus;
    m.io.value.precharge_aux = relay;
  }
  void precharge() {
    after(10);
    CHECK(c.state == BmsState::kPrecharge && c.command.air_minus && c.command.precharge);
  }
  /// Precharged in 100 ms.
  void activate() {
    precharge();
    path(true, true);
    after(10);
    link(950'000);
    after(100);
    CHECK(c.command.air_plus);
    m.io.value.air_plus_aux = true;
    after(10);
    path(true, false);
  }
  [[nodiscard]] bool closed() const { return commanded(c.command); }
};

// BMS-031
TEST(ContactorStep, ADcLinkThatIsNotMeasuredIsNotCharged) {
  precharge();
  path(true, true);
  after(10);
  link(1'000'000);
  m.dc_link_voltage.quality = Quality::kStale;
  after(100);
  CHECK_FALSE(c.command.air_plus);
  m.dc_link_voltage.quality = Quality::kGood;
  link(949'999);
  after(10);
  CHECK_FALSE(c.command.air_plus);
  link(950'000);
  after(10);
  CHECK(c.command.air_plus);
}

// BMS-034: driving and charging, in either direction of the current; what cannot wait does not.
TEST(ContactorStep, TheTorqueGoesFirstWhereThereIsTime) {
  for (const BmsState with : {BmsState::kTsActive, BmsState::kCharging}) {
    for (const std::int32_t sign : {1, -1}) {
      sound();
      activate();
      c.state = with;
      c.for_charge = state.charge.wants_contactors = with == BmsState::kCharging;
      state.faults.open = true;
      m.current.value = Current::from_raw(sign * 20'001);
      after(10);
      CHECK(c.state == BmsState::kFault && c.opening && closed());
      after(99);
      CHECK(c.opening && closed());
      m.current.value = Current::from_raw(sign * 20'000);
      after(0);
      CHECK_FALSE(c.opening || closed());
      LONGS_EQUAL(0, (now - c.opened_at).ms());
    }
  }
  sound();
  activate();
  m.current.value = amps(100);
  state.faults.open = state.faults.open_now = true;
  after(10);
  CHECK(c.state == BmsState::kFault);
  CHECK_FALSE(c.opening || closed());
}

// BMS-030: in a precharge there is no torque that would have to go, whatever is known of the current.
TEST(ContactorStep, APrechargeIsOpenedAtOnce) {
  for (const bool fault : {false, true}) {
    sound();
    precharge();
    m.current.quality = Quality::kStale;
    state.faults.open = fault;
    m.master.value.tractive_system = fault;
    after(10);
    CHECK(c.state == (fault ? BmsState::kFault : BmsState::kOpen));
    CHECK_FALSE(c.opening || closed());
  }
}

// BMS-034: a fault that comes while they wait for the torque does not begin the wait anew.
TEST(ContactorStep, AFaultDuringAnOpeningDoesNotDelayIt) {
  activate();
  m.current.value = amps(100);
  m.master.value.tractive_system = false;
  after(10);
  CHECK(c.state == BmsState::kOpen && c.opening);
  after(60);
  state.faults.open = true;
  after(10);
  CHECK(c.state == BmsState::kFault && c.opening && closed());
  after(29);
  CHECK(closed());
  after(1);
  CHECK_FALSE(closed());
}

// BMS-034: and nothing is begun anew before they are open, whatever the contacts say.
TEST(ContactorStep, AnOpeningIsNotOverBeforeItsCommand) {
  activate();
  m.current.value = amps(100);
  m.master.value.tractive_system = false;
  after(10);
  m.io.value.air_plus_aux = m.io.value.air_minus_aux = false;
  after(10);
  CHECK(c.state == BmsState::kOpen && c.opening && closed());
}

// BMS-033
TEST(ContactorStep, APrechargeIsGivenBackAfterItsTimeOfCoolingAndNoneThatWasNotSpent) {
  after(60'000);
  CHECK(c.precharges == 1);
  m.master.value.tractive_system = false;
  after(9'999);
  CHECK(c.precharges == 1);
  after(1);
  CHECK(c.precharges == 0);
  after(60'000);
  CHECK(c.precharges == 0);
}

// BMS-068: with open contacts the reading at no current is waited for, with a closed one it cannot be had.
TEST(ContactorStep, TheOffsetIsWaitedForWhileNoContactSaysClosed) {
  for (const bool welded : {false, true}) {
    sound();
    c.state = BmsState::kInvalid;
    m.master.value.tractive_system = false;
    state.current_check.offset_known = false;
    m.io.value.air_plus_aux = welded;
    after(10);
    CHECK(c.state == (welded ? BmsState::kIdle : BmsState::kInvalid));
    state.current_check.offset_known = true;
    after(10);
    CHECK(c.state == BmsState::kIdle);
  }
}

// BMS-018: the time begins with both contacts of the path, or, while they are not seen, with the command.
TEST(ContactorStep, TooFastIsReckonedFromTheContactsOfThisPrecharge) {
  const auto fails = [this](std::int32_t ms, bool minus, bool relay, bool low) {
    sound();
    c.closed_once = true;
    if (!low) link(600'000);
    precharge();
    after(100);
    path(minus, relay);
    after(10);
    link(950'000);
    after(ms);
    CHECK_EQUAL(c.precharge_too_fast, c.state == BmsState::kFault);
    CHECK_EQUAL(c.precharge_too_fast, !closed());
    return c.precharge_too_fast;
  };
  CHECK(fails(19, true, true, true));
  CHECK_FALSE(fails(20, true, true, true));
  CHECK_FALSE(fails(19, false, true, true));  // by the command
  CHECK_FALSE(fails(19, true, false, true));
  CHECK_FALSE(fails(19, true, true, false));

  sound();  // without a contact, by the command
  precharge();
  link(950'000);
  after(19);
  CHECK(c.precharge_too_fast);
  after(10);
  CHECK_FALSE(c.precharge_too_fast);  // for one step

  sound();  // and not by those of the last one
  activate();
  m.master.value.tractive_system = false;
  after(10);
  m.io.value.air_plus_aux = m.io.value.air_minus_aux = false;
  link(0);
  after(1'000);
  CHECK(c.state == BmsState::kIdle);
  m.master.value.tractive_system = true;
  precharge();
  after(100);
  path(true, true);
  after(10);
  link(950'000);
  after(10);
  CHECK(c.precharge_too_fast);
}

// BMS-032: what was up before has the time in which it would rise.
TEST(ContactorStep, ALinkThatWasUpClosesAfterTwoSeconds) {
  c.closed_once = true;
  link(960'000);
  precharge();
  path(true, true);
  after(1'999);
  CHECK_FALSE(c.command.air_plus);
  after(1);
  CHECK(c.command.air_plus);
}

// BMS-017
TEST(ContactorStep, APrechargeFailsAtItsTimeAndIsToldForOneStep) {
  precharge();
  path(true, true);
  after(4'999);
  CHECK(c.state == BmsState::kPrecharge && closed());
  after(1);
  CHECK(c.precharge_failed && c.state == BmsState::kFault);
  CHECK_FALSE(closed());
  after(10);
  CHECK_FALSE(c.precharge_failed);
}

// BMS-051: a car that drove waits for nobody's plug, one that was charged stays open until it is unplugged.
TEST(ContactorStep, WhatWasOpenedOnAChargerStaysOpenUntilItIsUnpluggedWhenItWasForTheCharge) {
  for (const bool for_charge : {false, true}) {
    sound();
    c.state = BmsState::kOpen;
    c.for_charge = for_charge;
    m.master.value.tractive_system = false;
    m.io.value.charge_switch = true;
    after(10);
    CHECK(c.state == (for_charge ? BmsState::kOpen : BmsState::kIdle));
  }
}

// BMS-051: contacts that fall open are a fault's affair.
TEST(ContactorStep, AChargeIsNotOverByItsContactsAlone) {
  activate();
  c.state = BmsState::kCharging;
  c.for_charge = state.charge.wants_contactors = true;
  m.master.value.tractive_system = false;
  m.io.value.air_plus_aux = m.io.value.air_minus_aux = false;
  after(10);
  CHECK(c.state == BmsState::kCharging && closed());
}

// BMS-051: what was closed for a charger is idle once its switch is off, and not before.
TEST(ContactorStep, AfterAChargeItIsIdleWhenTheChargersSwitchIsOff) {
  m.master = good(MasterRequest{false, false});
  for (const bool on : {true, false}) {
    c.state = BmsState::kOpen;
    c.for_charge = true;
    m.io.value.charge_switch = on;
    after(10);
    CHECK(c.state == (on ? BmsState::kOpen : BmsState::kIdle));
  }
}
