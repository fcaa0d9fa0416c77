// SPDX-License-Identifier: Apache-2.0
// What the BMS reads of an inverter that speaks the PM100's protocol.
#include "bms/ingest.hpp"

#include "bench.hpp"
#include "can_dbc/pm100.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;

TEST_GROUP(IngestPm100) {
  Config config = pack_config();
  State state{};
  std::uint32_t ms = 0;

  void setup() override {
    config.inverter_protocol = InverterProtocol::kPm100;
    config.motor_constant_unm_per_a = 200'000;
  }
  /// Twice, for the second frame in time is the first that is believed.
  template <class Message>
  const Measured& take(const Message& message) {
    for (int k = 0; k < 2; ++k) {
      Frame frame;
      can::encode(message, frame);
      ingest(config, {Instant::from_ms(ms += 10), {&frame, 1}}, state);
    }
    return state.measured;
  }
};

TEST(IngestPm100, VoltageSpeedAndTorqueArriveInTheirUnits) {
  can::Pm100Voltages voltages;
  voltages.dc_voltage_100uv = 3'456'000;
  LONGS_EQUAL(3'456'000, take(voltages).dc_link_voltage.value.raw());
  can::Pm100MotorPosition position;
  position.motor_speed_rpm = -4'321;
  LONGS_EQUAL(-4'321, take(position).motor_speed.value.raw());
  CHECK(state.measured.dc_link_voltage.good() && state.measured.motor_speed.good());
}

// BMS-067: what the power of the shaft is held against.
TEST(IngestPm100, TorqueIsThePhaseCurrentThatGivesIt) {
  for (const std::int32_t nm : {-230, -1, 0, 1, 100, 230}) {
    can::Pm100Torque torque;
    torque.feedback_mnm = 1'000 * nm;
    torque.commanded_mnm = 7'000;
    LONGS_EQUAL(5'000 * nm, take(torque).phase_current.value.raw());  // 0.2 Nm/A
    CHECK(state.measured.phase_current.good());
  }
}

// BMS-067
TEST(IngestPm100, WithoutAMotorConstantATorqueIsNoCurrent) {
  config.motor_constant_unm_per_a = 0;
  can::Pm100Torque torque;
  torque.feedback_mnm = 100'000;
  CHECK_FALSE(take(torque).phase_current.good());
}

// BMS-031: a link that reads below nothing is not one that is discharged.
TEST(IngestPm100, ANegativeDcLinkVoltageIsNoVoltage) {
  can::Pm100Voltages voltages;
  voltages.dc_voltage_100uv = 1'000;
  CHECK(take(voltages).dc_link_voltage.good());
  voltages.dc_voltage_100uv = 0;
  CHECK(take(voltages).dc_link_voltage.good());
  voltages.dc_voltage_100uv = -1'000;
  CHECK(take(voltages).dc_link_voltage.quality == Quality::kInvalid);
}

// BMS-001: beyond the range of the message, 1000 V and -100 V.
TEST(IngestPm100, AVoltageThatTheMessageDoesNotHaveIsNoVoltage) {
  for (const std::int32_t tenths : {10'000, 10'001, -1'001, 32'767, -32'768}) {
    for (int k = 0; k < 2; ++k) {
      Frame frame;
      can::encode(can::Pm100Voltages{}, frame);
      frame.data[0] = static_cast<std::uint8_t>(tenths);
      frame.data[1] = static_cast<std::uint8_t>(tenths >> 8);
      ingest(config, {Instant::from_ms(ms += 10), {&frame, 1}}, state);
    }
    CHECK_EQUAL(tenths == 10'000, state.measured.dc_link_voltage.good());
    LONGS_EQUAL(10'000'000, state.measured.dc_link_voltage.value.raw());
  }
}

// BMS-001
TEST(IngestPm100, AProtocolSaysNothingInACarOfAnother) {
  can::InverterStatus status;
  status.dc_link_voltage_100uv = 900'000;
  status.dc_link_voltage_ok = true;
  codec::Sealer sealer;
  for (int k = 0; k < 3; ++k) {
    Frame frame;
    can::encode(status, frame);
    sealer.seal(frame);
    ingest(config, {Instant::from_ms(ms += 10), {&frame, 1}}, state);
  }
  CHECK(state.measured.dc_link_voltage.quality == Quality::kNone);
  config.inverter_protocol = InverterProtocol::kPhaseCurrent;
  can::Pm100Voltages voltages;
  voltages.dc_voltage_100uv = 3'456'000;
  CHECK(take(voltages).dc_link_voltage.quality == Quality::kNone);
  config.inverter_protocol = InverterProtocol::kAmk;
  CHECK(take(voltages).dc_link_voltage.quality == Quality::kNone);
}
