// SPDX-License-Identifier: Apache-2.0
#include "race/actuators/command_receiver.hpp"

#include "codec/seal.hpp"
#include "fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap;
using namespace voltlap::plant;
using namespace voltlap::plant::test;

TEST_GROUP(CommandReceiver) {
  Car car{vtm16e(), true, 0.001};
  CommandReceiver receiver;
  codec::Sealer sealer;
  std::uint32_t tick = 0;

  template <class Message>
  Frame sealed(const Message& m) {
    Frame f;
    can::encode(m, f);
    sealer.seal(f);
    return f;
  }
  void receive(std::initializer_list<Frame> frames) {
    receiver.receive(Instant::from_ms(tick * 10), {frames.begin(), frames.size()}, car);
    car.renew(0.01);
    ++tick;
  }
  Frame close_all() {
    can::ContactorCommand m;
    m.air_plus_close = m.air_minus_close = true;
    return sealed(m);
  }
};

TEST(CommandReceiver, MovesTheContactorsThatTheBmsCommands) {
  for (int i = 0; i < 10; ++i) receive({close_all()});
  CHECK(car.contactors.main_closed());
  CHECK_FALSE(car.contactors.precharge.closed());
}

TEST(CommandReceiver, OpensEveryContactorWhenTheCommandFallsSilent) {
  for (int i = 0; i < 10; ++i) receive({close_all()});
  int silent_ms = 0;
  while (car.contactors.air_plus.closed() || car.contactors.air_minus.closed()) {
    receive({});
    silent_ms += 10;
    CHECK(silent_ms < 250);
  }
  CHECK(silent_ms > 40);
}

TEST(CommandReceiver, AFrameWithABrokenSealMovesNothing) {
  for (int i = 0; i < 20; ++i) {
    Frame f = close_all();
    f.data[7] = static_cast<std::uint8_t>(f.data[7] ^ 1U);
    receive({f});
  }
  CHECK_FALSE(car.contactors.air_plus.closed());
}

TEST(CommandReceiver, ARepeatedFrameKeepsNothingAlive) {
  for (int i = 0; i < 10; ++i) receive({close_all()});
  const Frame stuck = close_all();
  for (int i = 0; i < 20; ++i) receive({stuck});
  CHECK_FALSE(car.contactors.air_plus.closed());
}

TEST(CommandReceiver, TheInverterFollowsAnEnabledCurrent) {
  can::InverterCommand m;
  m.phase_current_ma = 123'400;
  m.phase_current_ok = m.enable = true;
  receive({sealed(m)});
  receive({sealed(m)});
  receive({sealed(m)});
  DOUBLES_EQUAL(123.4, car.inverter.current(96.0), 1e-9);
  m.enable = false;
  receive({sealed(m)});
  DOUBLES_EQUAL(0.0, car.inverter.current(96.0), 0.0);
}

TEST(CommandReceiver, ASilentNodeHasNoStateAndNoLimit) {
  for (int i = 0; i < 5; ++i) {
    can::MasterStatus master;
    master.drive_state = can::DriveState::kReadyToDrive;
    can::BmsLimits limits;
    limits.discharge_limit_ma = 300'000;
    limits.discharge_limit_ok = true;
    receive({sealed(master), sealed(limits)});
  }
  CHECK(receiver.master().drive_state == can::DriveState::kReadyToDrive);
  LONGS_EQUAL(300'000, receiver.limits().discharge_limit_ma);
  for (int i = 0; i < can::MasterStatus::kTimeoutMs / 10; ++i) receive({});
  CHECK(receiver.master().drive_state == can::DriveState::kInvalid);
  LONGS_EQUAL(0, receiver.limits().discharge_limit_ma);
}

TEST(CommandReceiver, ShuntsFollowTheirCommandAndEndWithItsSilence) {
  Car whole{vtm16e(), false, 0.001};
  const auto give = [&](std::initializer_list<Frame> frames) {
    receiver.receive(Instant::from_ms(tick++ * 10), {frames.begin(), frames.size()}, whole);
  };
  for (int i = 0; i < 10; ++i) {
    can::BalancingCommand m;
    m.cells[0] = 1U << 5U | 1U << 23U;
    give({sealed(m)});
    for (int k = 0; k < 9; ++k) give({});
  }
  CHECK(whole.pack().bleeding() == (std::vector<std::size_t>{5, 23}));
  int silent_ms = 90;
  while (!whole.pack().bleeding().empty()) {
    give({});
    silent_ms += 10;
    CHECK(silent_ms <= 510);
  }
  CHECK(silent_ms >= 400);
}

TEST(CommandReceiver, AChargerIsToldWhatTheBmsAsks) {
  car.charger.plugged = true;
  can::ChargerCommand m;
  m.voltage_max_100uv = 1'000'000;
  m.current_max_ma = 12'300;
  m.control = can::ChargerControl::kCharge;
  receive({sealed(m)});
  receive({sealed(m)});
  for (int i = 0; i < 300; ++i) car.charger.advance(0.01, 90.0, true);
  DOUBLES_EQUAL(12.3, car.charger.current_a(), 0.1);
}
