// SPDX-License-Identifier: Apache-2.0
#include "master/ingest.hpp"

#include <iterator>
#include <utility>
#include <vector>

#include "CppUTest/TestHarness.h"
#include "codec/seal.hpp"

using namespace voltlap;
using namespace voltlap::master;

TEST_GROUP(MasterIngest) {
  Receiver receiver{};
  Instant now = Instant::from_ms(1'000);
  std::uint8_t counter = 0;

  template <class Message>
  Frame sealed(const Message& m) {
    Frame frame;
    encode(m, frame);
    codec::seal(frame, counter);
    return frame;
  }
  void receive(const Frame& frame) { ingest(now, FrameView{&frame, 1}, receiver); }
  void silence(std::int32_t ms) {
    now = now + Duration::from_ms(ms);
    ingest(now, FrameView{}, receiver);
  }
  template <class Message>
  void send(const Message& m) {
    receive(sealed(m));
    ++counter;
  }
  static can::Pedals pedals(std::int32_t apps1 = 20'000) {
    can::Pedals m;
    m.apps1_100uv = apps1;
    m.apps2_100uv = 10'000;
    m.apps1_ok = m.apps2_ok = m.brake_front_ok = m.brake_rear_ok = true;
    return m;
  }
  void synchronise() {
    send(pedals());
    send(pedals());
  }
};

// MST-060
TEST(MasterIngest, FirstFrameOnlySynchronisesAndTheSecondCounts) {
  send(pedals());
  CHECK(receiver.input.apps1.quality == Quality::kNone);
  send(pedals());
  CHECK(receiver.input.apps1.good());
  LONGS_EQUAL(20'000, receiver.input.apps1.value.raw());
}

// MST-060
TEST(MasterIngest, SampleGoesStaleWhenItsAgeReachesItsTimeout) {
  synchronise();
  silence(can::Pedals::kTimeoutMs - 1);
  CHECK(receiver.input.apps1.good());
  silence(1);
  CHECK(receiver.input.apps1.quality == Quality::kStale);
}

// MST-060
TEST(MasterIngest, RepeatedFrameRefreshesNothing) {
  synchronise();
  counter = static_cast<std::uint8_t>(counter - 1);
  const Frame repeated = sealed(pedals(30'000));
  for (int i = 0; i < can::Pedals::kTimeoutMs / 10; ++i) {
    now = now + Duration::from_ms(10);
    receive(repeated);
    LONGS_EQUAL(20'000, receiver.input.apps1.value.raw());
  }
  CHECK(receiver.input.apps1.quality == Quality::kStale);
}

// MST-060
TEST(MasterIngest, EveryFlippedBitIsRefused) {
  synchronise();
  for (int bit = 0; bit < 64; ++bit) {
    Frame frame = sealed(pedals(30'000));
    frame.data[bit / 8] = static_cast<std::uint8_t>(frame.data[bit / 8] ^ (1U << (bit % 8)));
    receive(frame);
    LONGS_EQUAL(20'000, receiver.input.apps1.value.raw());
  }
}

// MST-060
TEST(MasterIngest, WrongLengthAndAllZeroDataAreRefused) {
  synchronise();
  Frame frame = sealed(pedals(30'000));
  frame.dlc = 7;
  receive(frame);
  Frame zero;
  zero.id = can::Pedals::kId;
  zero.dlc = 8;
  receive(zero);
  LONGS_EQUAL(20'000, receiver.input.apps1.value.raw());
}

// MST-060
TEST(MasterIngest, InvalidCodeKeepsTheValueButNotItsQuality) {
  synchronise();
  can::Pedals m = pedals(30'000);
  m.apps1_ok = false;
  send(m);
  CHECK(receiver.input.apps1.quality == Quality::kInvalid);
  LONGS_EQUAL(20'000, receiver.input.apps1.value.raw());
  CHECK(receiver.input.apps2.good());
}

TEST(MasterIngest, LimitWithoutAReasonIsNoLimit) {
  can::BmsLimits m;
  m.discharge_limit_ma = m.charge_limit_ma = 200'000;
  m.discharge_limit_ok = m.charge_limit_ok = true;
  m.discharge_reason = can::LimitReason::kConfigMaximum;
  send(m);
  send(m);
  CHECK(receiver.input.discharge_limit.good());
  CHECK_FALSE(receiver.input.charge_limit.good());
  LONGS_EQUAL(200'000, receiver.input.discharge_limit.value.raw());
}

// MST-060
TEST(MasterIngest, LimitThatIsImpossibleIsNoLimit) {
  for (const bool discharge : {true, false}) {
    receiver = Receiver{};
    can::BmsLimits m;
    m.discharge_limit_ma = m.charge_limit_ma = 200'000;
    m.discharge_reason = m.charge_reason = can::LimitReason::kConfigMaximum;
    for (int i = 0; i < 2; ++i) {
      Frame frame;
      encode(m, frame);
      frame.data[discharge ? 1 : 3] = 0xFF;  // beyond 1000 A
      codec::seal(frame, counter++);
      receive(frame);
    }
    CHECK_EQUAL(!discharge, receiver.input.discharge_limit.good());
    CHECK_EQUAL(discharge, receiver.input.charge_limit.good());
  }
}

TEST(MasterIngest, EachLimitNeedsAReasonOfItsOwn) {
  can::BmsLimits m;
  m.discharge_limit_ma = m.charge_limit_ma = 200'000;
  m.discharge_limit_ok = m.charge_limit_ok = true;
  m.charge_reason = can::LimitReason::kConfigMaximum;
  send(m);
  send(m);
  CHECK_FALSE(receiver.input.discharge_limit.good());
  CHECK(receiver.input.charge_limit.good());
}

TEST(MasterIngest, BmsThatReportsNoStateIsNotGood) {
  can::BmsStatus m;
  send(m);
  send(m);
  CHECK_FALSE(receiver.input.bms_state.good());
}

TEST(MasterIngest, OtherFramesLandInTheirSamples) {
  can::WheelSpeeds wheels;
  wheels.front_left_mmps = 12'280;
  wheels.front_right_mmps = 12'300;
  wheels.rear_left_mmps = 12'320;
  wheels.rear_right_mmps = 12'340;
  wheels.front_left_ok = wheels.front_right_ok = wheels.rear_left_ok = wheels.rear_right_ok = true;
  can::InverterStatus inverter;
  inverter.dc_link_voltage_100uv = 898'700;
  inverter.dc_link_voltage_ok = true;
  inverter.motor_speed_rpm = -321;
  inverter.motor_speed_ok = true;
  inverter.state = can::InverterState::kEnabled;
  can::PackSensor pack;
  pack.pack_current_ma = -123'456;
  pack.pack_voltage_100uv = 912'300;
  pack.pack_current_ok = pack.pack_voltage_ok = true;
  can::VehicleIo io;
  io.shutdown_closed = io.rtd_button = true;
  can::MotorTemperatures hot;
  hot.motor_dc = 1'234;
  hot.motor_ok = true;
  for (int i = 0; i < 2; ++i) {
    receive(sealed(wheels));
    receive(sealed(inverter));
    receive(sealed(pack));
    receive(sealed(io));
    receive(sealed(hot));
    ++counter;
  }
  const Input& in = receiver.input;
  for (int i = 0; i < 4; ++i) LONGS_EQUAL(12'280 + 20 * i, in.wheel_speed[i].value.raw());
  LONGS_EQUAL(898'700, in.dc_link_voltage.value.raw());
  LONGS_EQUAL(-321, in.motor_speed.value.raw());
  CHECK(in.inverter_state.value == InverterState::kEnabled);
  LONGS_EQUAL(-123'456, in.pack_current.value.raw());
  LONGS_EQUAL(912'300, in.pack_voltage.value.raw());
  CHECK(in.switches.value.shutdown_closed && in.switches.value.rtd_button && !in.switches.value.ts_on_button);
  LONGS_EQUAL(1'234, in.motor_temperature.value.raw());
  CHECK_FALSE(in.inverter_temperature.good());
}

// BMS-037
TEST(MasterIngest, AnOpenInterlockIsAnOpenShutdownCircuit) {
  can::VehicleIo io;
  io.shutdown_closed = true;
  for (const bool open : {false, true, false}) {
    io.interlock_open = open;
    for (int i = 0; i < 2; ++i) {
      receive(sealed(io));
      ++counter;
    }
    CHECK(receiver.input.switches.good());
    CHECK_EQUAL(!open, receiver.input.switches.value.shutdown_closed);
  }
  io.shutdown_closed = false;
  receive(sealed(io));
  CHECK_FALSE(receiver.input.switches.value.shutdown_closed);
}

// MST-039
TEST(MasterIngest, TheEndsOfTheRangeAreNoTemperatures) {
  const auto good = [this](std::int32_t motor_dc, std::int32_t inverter_dc) {
    can::MotorTemperatures m;
    m.motor_ok = m.inverter_ok = true;
    m.motor_dc = motor_dc;
    m.inverter_dc = inverter_dc;
    for (int i = 0; i < 2; ++i) {
      receive(sealed(m));
      ++counter;
    }
    return std::pair{receiver.input.motor_temperature.good(), receiver.input.inverter_temperature.good()};
  };
  CHECK((good(-389, 2'449) == std::pair{true, true}));
  CHECK((good(-390, 300) == std::pair{false, true}));
  CHECK((good(300, 2'450) == std::pair{true, false}));
  CHECK((good(2'500, -400) == std::pair{false, false}));
}

namespace {

/// Whether each sample of an input is good, in one order, with the time-out of its message.
struct Watched {
  const char* name;
  bool good;
  std::int32_t timeout_ms;
};
template <class Message, class T>
Watched watched(const char* name, const Sample<T>& sample) { return {name, sample.good(), Message::kTimeoutMs}; }

std::vector<Watched> every_sample(const Input& in) {
  std::vector<Watched> all = {watched<can::Pedals>("apps1", in.apps1),
                              watched<can::Pedals>("apps2", in.apps2),
                              watched<can::Pedals>("brake_front", in.brake_front),
                              watched<can::Pedals>("brake_rear", in.brake_rear),
                              watched<can::InverterStatus>("motor_speed", in.motor_speed),
                              watched<can::InverterStatus>("dc_link_voltage", in.dc_link_voltage),
                              watched<can::InverterStatus>("inverter_state", in.inverter_state),
                              watched<can::InverterStatus>("phase_current", in.phase_current),
                              watched<can::PackSensor>("pack_current", in.pack_current),
                              watched<can::PackSensor>("pack_voltage", in.pack_voltage),
                              watched<can::VehicleIo>("switches", in.switches),
                              watched<can::BmsLimits>("discharge_limit", in.discharge_limit),
                              watched<can::BmsLimits>("charge_limit", in.charge_limit),
                              watched<can::BmsStatus>("bms_state", in.bms_state),
                              watched<can::MotorTemperatures>("motor_temperature", in.motor_temperature),
                              watched<can::MotorTemperatures>("inverter_temperature", in.inverter_temperature)};
  for (const Sample<Speed>& wheel : in.wheel_speed) all.push_back(watched<can::WheelSpeeds>("wheel_speed", wheel));
  return all;
}

}  // namespace

// MST-060
TEST(MasterIngest, EverySampleGoesStaleAtTheTimeOutOfItsMessage) {
  can::Pedals pedal_box = pedals();
  can::WheelSpeeds wheels;
  wheels.front_left_ok = wheels.front_right_ok = wheels.rear_left_ok = wheels.rear_right_ok = true;
  can::InverterStatus inverter;
  inverter.motor_speed_ok = inverter.dc_link_voltage_ok = inverter.phase_current_ok = true;
  can::PackSensor pack;
  pack.pack_current_ok = pack.pack_voltage_ok = true;
  can::BmsLimits limits;
  limits.discharge_limit_ok = limits.charge_limit_ok = true;
  limits.discharge_reason = limits.charge_reason = can::LimitReason::kConfigMaximum;
  can::BmsStatus bms;
  bms.state = BmsState::kIdle;
  can::MotorTemperatures hot;
  hot.motor_ok = hot.inverter_ok = true;
  hot.motor_dc = hot.inverter_dc = 400;
  for (int i = 0; i < 2; ++i) {
    const Frame frames[] = {sealed(pedal_box), sealed(wheels), sealed(inverter), sealed(pack),
                            sealed(can::VehicleIo{}), sealed(limits), sealed(bms), sealed(hot)};
    ingest(now, FrameView{frames, std::size(frames)}, receiver);
    ++counter;
  }
  for (std::int32_t age_ms = 0; age_ms <= 600; ++age_ms) {
    for (const Watched& sample : every_sample(receiver.input)) {
      CHECK_EQUAL_TEXT(age_ms < sample.timeout_ms, sample.good, sample.name);
    }
    silence(1);
  }
}

// MST-060: after 49.7 days the clock is where it was.
TEST(MasterIngest, CountOfBeforeALongSilenceIsNotTakenUpWhenTheClockHasGoneRound) {
  synchronise();
  for (std::uint32_t days = 0; days < 8; ++days) silence(std::int32_t{1} << 29);
  LONGS_EQUAL(1'000, now.ms());
  now = now + Duration::from_ms(10);
  send(pedals(30'000));
  CHECK_FALSE(receiver.input.apps1.good());
  now = now + Duration::from_ms(10);
  send(pedals(30'000));
  CHECK(receiver.input.apps1.good());
}
