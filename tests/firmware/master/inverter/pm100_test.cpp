// SPDX-License-Identifier: Apache-2.0
#include "master/inverter/pm100.hpp"

#include <random>

#include "CppUTest/TestHarness.h"
#include "codec/seal.hpp"
#include "master/ingest.hpp"
#include "master/inverter_command.hpp"
#include "master/transmit.hpp"

using namespace voltlap;
using namespace voltlap::master;

namespace {

constexpr std::int32_t kConstant = 150'000;  // 0.15 Nm/A

template <class Message>
Frame frame_of(const Message& m) {
  Frame frame;
  encode(m, frame);
  return frame;
}

}  // namespace

TEST_GROUP(Pm100) {
  Receiver receiver{{}, {InverterProtocol::kPm100, kConstant, {}, {}}, {}};
  Instant now = Instant::from_ms(1'000);
  can::Pm100States states{};
  can::Pm100Faults faults{};
  can::Pm100Torque torque{};

  void receive(const Frame& frame) { ingest(now, FrameView{&frame, 1}, receiver); }
  void fast() {
    now = now + Duration::from_ms(10);
    receive(frame_of(torque));
  }
  /// The slow frames and then ten periods of the fast one.
  void run(int rounds = 1) {
    for (int i = 0; i < rounds; ++i) {
      receive(frame_of(states));
      receive(frame_of(faults));
      for (int k = 0; k < 10; ++k) fast();
    }
  }
  [[nodiscard]] bool state_is(InverterState wanted) const {
    return receiver.input.inverter_state.good() && receiver.input.inverter_state.value == wanted;
  }
};

// MST-063
TEST(Pm100, LockedOutCountsAsOffAndIsSentNothingButADisabledCommand) {
  states.lockout = true;
  run(3);
  CHECK(state_is(InverterState::kOff));
  const InverterCommand command =
      inverter_command(Current::from_raw(100'000), DriveState::kReadyToDrive, receiver.input.inverter_state);
  CHECK_FALSE(command.enable);
  states.lockout = false;
  run();
  CHECK(state_is(InverterState::kDisabled));
}

// MST-063
TEST(Pm100, EveryFaultWordHasItsNameAndTheTimeOutItsOwn) {
  using W = std::uint16_t can::Pm100Faults::*;
  for (const W word : {&can::Pm100Faults::post_low, &can::Pm100Faults::post_high, &can::Pm100Faults::run_low,
                       &can::Pm100Faults::run_high}) {
    for (unsigned bit = 0; bit < 16; ++bit) {
      can::Pm100Faults m;
      m.*word = static_cast<std::uint16_t>(1U << bit);
      const bool lost = word == &can::Pm100Faults::run_low && bit == 11;
      const InverterState state = pm100_state(Pm100Flags{true, true}, pm100_fault(m));
      CHECK(state == (lost ? InverterState::kCommandTimeout : InverterState::kFault));
    }
  }
  faults.run_low = (1U << 11) | 1U;
  CHECK(pm100_fault(faults) == Pm100Fault::kRun);
  faults.run_low = 1U << 11;
  faults.run_high = 1U;
  CHECK(pm100_fault(faults) == Pm100Fault::kRun);
}

// MST-063
TEST(Pm100, StateNeedsTheSlowFramesAndASignOfLife) {
  for (int k = 0; k < 40; ++k) fast();
  CHECK_FALSE(receiver.input.inverter_state.good());
  states.enabled = true;
  run(3);
  CHECK(state_is(InverterState::kEnabled));
  for (int k = 0; k < 44; ++k) fast();  // 540 ms after the last slow one: four lost in a row are survived
  CHECK((now - receiver.input.inverter_state.time).ms() == 0);
  for (int k = 0; k < 3; ++k) fast();
  CHECK((now - receiver.input.inverter_state.time).ms() > 0);
}

// MST-063
TEST(Pm100, EachSlowFrameAndTheSignOfLifeAreNeeded) {
  const Frame kinds[] = {frame_of(states), frame_of(faults), frame_of(torque)};
  for (std::size_t missing = 0; missing < 3; ++missing) {
    receiver = Receiver{{}, {InverterProtocol::kPm100, kConstant, {}, {}}, {}};
    run(3);
    CHECK(state_is(InverterState::kDisabled));
    for (int k = 0; k < 60; ++k) {  // 600 ms without it
      now = now + Duration::from_ms(10);
      ingest(now, FrameView{&kinds[missing == 0 ? 1 : 0], 1}, receiver);
      ingest(now, FrameView{&kinds[missing == 2 ? 1 : 2], 1}, receiver);
    }
    CHECK_FALSE(receiver.input.inverter_state.good());
  }
}

// MST-060
TEST(Pm100, ItsFramesLandInTheirSamples) {
  can::Pm100ModuleTemperatures modules;
  modules.module_a_dc = 410;
  modules.module_b_dc = 420;
  modules.module_c_dc = 430;
  can::Pm100MotorTemperatures motor;
  motor.motor_dc = 555;
  motor.motor_ok = true;
  can::Pm100MotorPosition position;
  position.motor_speed_rpm = -321;
  position.motor_speed_ok = true;
  can::Pm100Currents currents;
  currents.dc_current_ma = -12'300;
  currents.dc_current_ok = true;
  can::Pm100Voltages voltages;
  voltages.dc_voltage_100uv = 3'210'000;
  voltages.dc_voltage_ok = true;
  const auto twice = [this](const Frame& frame) {
    for (int i = 0; i < 2; ++i) receive(frame);
  };
  const Input& in = receiver.input;
  for (const Frame& frame : {frame_of(modules), frame_of(motor), frame_of(position), frame_of(currents),
                             frame_of(voltages)}) {
    twice(frame);
  }
  LONGS_EQUAL(430, in.inverter_temperature.value.raw());
  LONGS_EQUAL(555, in.motor_temperature.value.raw());
  LONGS_EQUAL(-321, in.motor_speed.value.raw());
  LONGS_EQUAL(-12'300, in.inverter_dc_current.value.raw());
  LONGS_EQUAL(3'210'000, in.dc_link_voltage.value.raw());
  CHECK(in.inverter_temperature.good() && in.motor_temperature.good() && in.motor_speed.good() &&
        in.inverter_dc_current.good() && in.dc_link_voltage.good());
  voltages.dc_voltage_100uv = 0;
  twice(frame_of(voltages));
  CHECK(in.dc_link_voltage.good());
  voltages.dc_voltage_100uv = -10'000;  // no voltage that a DC link can have
  twice(frame_of(voltages));
  CHECK_FALSE(in.dc_link_voltage.good());
  twice(frame_of(can::Pm100Voltages{}));
  CHECK(in.dc_link_voltage.good());
  Frame unknown = frame_of(voltages);
  unknown.data[0] = 0xFF;
  unknown.data[1] = 0x7F;  // beyond the signal's range
  twice(unknown);
  CHECK_FALSE(in.dc_link_voltage.good());
  for (int k = 0; k < 10; ++k) fast();
  CHECK_FALSE(in.inverter_dc_current.good());  // 100 ms
}

// MST-034, MST-039: the hottest module counts, and one that is not known could be hotter.
TEST(Pm100, HottestOfThreeModulesIsTheInvertersTemperature) {
  using M = can::Pm100ModuleTemperatures;
  std::size_t byte = 1;
  for (std::int32_t M::*module : {&M::module_a_dc, &M::module_b_dc, &M::module_c_dc}) {
    M m;
    m.module_a_dc = m.module_b_dc = m.module_c_dc = 300;
    m.*module = 800;
    for (int i = 0; i < 2; ++i) receive(frame_of(m));
    LONGS_EQUAL(800, receiver.input.inverter_temperature.value.raw());
    CHECK(receiver.input.inverter_temperature.good());
    Frame unknown = frame_of(m);
    unknown.data[byte - 1] = 0xFF;
    unknown.data[byte] = 0x7F;  // beyond the signal's range
    receive(unknown);
    CHECK_FALSE(receiver.input.inverter_temperature.good());
    byte += 2;
  }
}

// MST-034, MST-039: an open or shorted sensor of one module is not hidden by the others.
TEST(Pm100, OneModuleAtTheEndOfItsRangeIsATemperatureThatIsNotKnown) {
  using M = can::Pm100ModuleTemperatures;
  for (std::int32_t M::*module : {&M::module_a_dc, &M::module_b_dc, &M::module_c_dc}) {
    for (const std::int32_t end : {-400, -390, 2'450}) {
      M m;
      m.module_a_dc = m.module_b_dc = m.module_c_dc = 300;
      for (int i = 0; i < 2; ++i) receive(frame_of(m));
      CHECK(receiver.input.inverter_temperature.good());
      m.*module = end;
      for (int i = 0; i < 2; ++i) receive(frame_of(m));
      CHECK_FALSE(receiver.input.inverter_temperature.good());
    }
    M cold;
    cold.module_a_dc = cold.module_b_dc = cold.module_c_dc = 300;
    cold.*module = -389;
    for (int i = 0; i < 2; ++i) receive(frame_of(cold));
    CHECK(receiver.input.inverter_temperature.good());
  }
}

// MST-063: what a car with a PM100 does not have says nothing of it.
TEST(Pm100, FramesOfAnInverterThatTheCarDoesNotHaveAreNotHeard) {
  can::InverterStatus status;
  status.state = InverterState::kEnabled;
  can::MotorTemperatures hot;
  hot.motor_dc = 300;
  hot.motor_ok = true;
  for (std::uint8_t counter = 0; counter < 4; ++counter) {
    now = now + Duration::from_ms(10);
    Frame frames[] = {frame_of(status), frame_of(hot)};
    for (Frame& frame : frames) codec::seal(frame, counter);
    ingest(now, FrameView{frames, 2}, receiver);
  }
  CHECK_FALSE(receiver.input.inverter_state.good());
  CHECK_FALSE(receiver.input.motor_temperature.good());
}

TEST(Pm100, TorqueWithoutAConstantIsNoCurrent) {
  receiver.inverter.motor_constant_unm_per_a = 0;
  torque.feedback_mnm = 50'000;
  run();
  LONGS_EQUAL(0, receiver.input.phase_current.value.raw());
}

// MST-060
TEST(Pm100, AWrongLengthRefreshesNothing) {
  run(3);
  torque.feedback_mnm = 50'000;
  Frame shorter = frame_of(torque);
  shorter.dlc = 7;
  now = now + Duration::from_ms(10);
  receive(shorter);
  LONGS_EQUAL(0, receiver.input.phase_current.value.raw());
  fast();
  LONGS_EQUAL(333'333, receiver.input.phase_current.value.raw());
}

// MST-060
TEST(Pm100, OtherInvertersFramesAreNotHeard) {
  Receiver other{};
  for (int k = 0; k < 5; ++k) {
    now = now + Duration::from_ms(10);
    const Frame frames[] = {frame_of(torque), frame_of(states), frame_of(faults), frame_of(can::Pm100Command{})};
    ingest(now, FrameView{frames, 4}, other);
  }
  CHECK_FALSE(other.input.inverter_state.good());
  CHECK_FALSE(other.input.phase_current.good());
  CHECK_FALSE(other.input.foreign_frames);
}

// MST-067
TEST(Pm100, ACommandFromTheBusIsForeignForASecond) {
  run();
  CHECK_FALSE(receiver.input.foreign_frames);
  receive(frame_of(can::Pm100Command{}));
  CHECK(receiver.input.foreign_frames);
  for (int k = 0; k < 99; ++k) fast();
  CHECK(receiver.input.foreign_frames);
  fast();
  CHECK_FALSE(receiver.input.foreign_frames);
}

// MST-067: power-on is no command.
TEST(Pm100, NobodyIsForeignInTheFirstSecond) {
  for (now = Instant{}; now.ms() < 1'000;) {
    fast();
    CHECK_FALSE(receiver.input.foreign_frames);
  }
}

// MST-067
TEST(Pm100, CommandThatDiffersFromItsOwnInAnythingIsForeign) {
  const auto heard = [this](std::size_t byte, bool shorter) {
    receiver.inverter.pm100 = Pm100Reading{};
    receiver.inverter.sent = SentCommands{};
    codec::Sealer sealer;
    TxQueue tx;
    transmit_to_inverter(Output{}, receiver.inverter, sealer, tx);
    Frame frame = tx[0];
    if (byte < Frame::kMaxBytes) frame.data[byte] = static_cast<std::uint8_t>(frame.data[byte] + 1);
    if (shorter) frame.dlc = 7;
    receive(frame);
    return receiver.input.foreign_frames;
  };
  CHECK_FALSE(heard(8, false));
  CHECK(heard(8, true));
  for (std::size_t byte = 0; byte < Frame::kMaxBytes; ++byte) CHECK(heard(byte, false));
}

// MST-067
TEST(Pm100, WhatItHasSentItselfIsNotForeignOnceAndNeverLater) {
  codec::Sealer sealer;
  TxQueue tx;
  for (int k = 0; k < 5; ++k) transmit_to_inverter(Output{}, receiver.inverter, sealer, tx);
  for (std::size_t k = 1; k < 5; ++k) receive(tx[k]);
  CHECK_FALSE(receiver.input.foreign_frames);
  receive(tx[4]);
  CHECK(receiver.input.foreign_frames);
  for (int k = 0; k < 100; ++k) fast();
  CHECK_FALSE(receiver.input.foreign_frames);
  receive(tx[0]);  // too old to be an echo
  CHECK(receiver.input.foreign_frames);
}

// MST-064
TEST(Pm100, TorqueIsCutTowardsZeroAndNeverAboveItsLimit) {
  Output out;
  out.drive_state = DriveState::kReadyToDrive;
  out.enable = true;
  for (std::int32_t ma = -550'000; ma <= 550'000; ma += 317) {
    out.phase_current = Current::from_raw(ma);
    out.current_limit = Current::from_raw(ma < 0 ? -ma : ma);
    const can::Pm100Command m = pm100_command(out, kConstant, 3);
    const std::int64_t exact_nnm = std::int64_t{ma} * kConstant;
    const std::int64_t sent_nnm = std::int64_t{m.torque_mnm} * 1'000'000;
    CHECK(ma >= 0 ? sent_nnm <= exact_nnm && exact_nnm - sent_nnm < 100'000'000
                  : sent_nnm >= exact_nnm && sent_nnm - exact_nnm < 100'000'000);
    CHECK(m.torque_limit_mnm >= 100 && m.torque_mnm <= m.torque_limit_mnm && -m.torque_mnm <= m.torque_limit_mnm);
    CHECK(m.forward && m.enable && !m.speed_mode && !m.discharge && m.speed_rpm == 0);
  }
}

// MST-064
TEST(Pm100, DisabledCommandIsAllZeroButDirectionAndCount) {
  const can::Pm100Command m = pm100_command(Output{}, kConstant, 15);
  const Frame frame = frame_of(m);
  const std::uint8_t wanted[] = {0, 0, 0, 0, 1, 0xF0, 0, 0};
  MEMCMP_EQUAL(wanted, frame.data, 8);
}

// MST-064
TEST(Pm100, CountGoesUpByOneRoundAndRound) {
  codec::Sealer sealer;
  for (unsigned k = 0; k < 40; ++k) {
    TxQueue tx;
    transmit_to_inverter(Output{}, receiver.inverter, sealer, tx);
    LONGS_EQUAL(1, tx.size());
    LONGS_EQUAL(can::Pm100Command::kId, tx[0].id);
    LONGS_EQUAL(k % 16, tx[0].data[5] >> 4);
  }
}

// MST-063: frames of every kind in drawn order, lost, repeated, cut: enabled is what an unlocked inverter without fault
// alone is sent.
TEST(Pm100, DrawnFramesNeverEnableALockedOne) {
  std::mt19937 draw(20'261);
  const auto chance = [&draw](unsigned percent) { return draw() % 100 < percent; };
  bool locked_shown = false, fault_shown = false;
  int enabled = 0;
  for (int k = 0; k < 60'000; ++k) {
    now = now + Duration::from_ms(static_cast<std::int32_t>(10 * (1 + draw() % (chance(2) ? 40 : 1))));
    if (chance(3)) states.lockout = !states.lockout;
    if (chance(2)) faults.run_low = static_cast<std::uint16_t>(chance(30) ? 1U << (draw() % 16) : 0);
    if (chance(1)) faults.post_high = static_cast<std::uint16_t>(chance(30) ? 4 : 0);
    Frame frames[] = {chance(50) ? frame_of(states) : frame_of(faults), frame_of(torque)};
    if (chance(5)) frames[0].dlc = 5;
    ingest(now, FrameView{frames, chance(95) ? 2U : 1U}, receiver);
    locked_shown = receiver.inverter.pm100.flags.value.lockout;
    fault_shown = receiver.inverter.pm100.fault.value != Pm100Fault::kNone;
    const bool fresh = receiver.input.inverter_state.time.ms() == now.ms();
    const InverterCommand command =
        inverter_command(Current::from_raw(50'000), DriveState::kReadyToDrive, receiver.input.inverter_state);
    if (fresh) CHECK_FALSE(command.enable && (locked_shown || fault_shown));
    enabled += command.enable ? 1 : 0;
  }
  CHECK(enabled > 1'000);
}
