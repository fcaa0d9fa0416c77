// SPDX-License-Identifier: Apache-2.0
#include "master/inverter/amk.hpp"

#include <random>

#include "CppUTest/TestHarness.h"
#include "firmware/master/inverter/amk_bench.hpp"

using namespace voltlap;
using namespace voltlap::master;
using namespace voltlap::master::bench;

TEST_GROUP(Amk) {
  AmkBench bench;

  codec::AmkSetpoints sent(const Output& output, std::size_t wheel) {
    return amk_setpoints(output, wheel, bench.receiver.inverter.amk_scale);
  }
  static Output enabled(std::int32_t ma) {
    Output out;
    out.enable = out.dc_on = true;
    for (Current& current : out.wheel.of) current = Current::from_raw(ma);
    return out;
  }
};

TEST(Amk, TheBitsStandWhereTheMakerHasThem) {
  codec::AmkSetpoints m;
  m.inverter_on = m.enable = true;
  m.target_velocity_ok = m.torque_limit_positive_ok = m.torque_limit_negative_ok = true;
  m.target_velocity_rpm = 0x1234;
  m.torque_limit_positive_ppm = 2'142'000;
  m.torque_limit_negative_ppm = -1'000;
  const Frame frame = wheel_frame(m, 3);
  LONGS_EQUAL(0x189, frame.id);
  const std::uint8_t expected[] = {0x00, 0x05, 0x34, 0x12, 0x5E, 0x08, 0xFF, 0xFF};
  MEMCMP_EQUAL(expected, frame.data, 8);
  LONGS_EQUAL(107'200, codec::amk_current_ma(16'384));
  LONGS_EQUAL(-53'600, codec::amk_current_ma(-8'192));
}

TEST(Amk, ReadingsOfAllFourBecomeOne) {
  for (std::size_t k = 0; k < kWheels; ++k) {
    bench.actual1[k].actual_velocity_rpm = 1'000 + 10 * static_cast<std::int32_t>(k);
    bench.actual1[k].torque_current = 1'000;
    bench.actual2[k].motor_temperature_dc = 500 + static_cast<std::int32_t>(k);
    bench.actual2[k].igbt_temperature_dc = 700;
  }
  bench.actual1[1].actual_velocity_rpm = -2'000;
  bench.run(3);
  const Input& in = bench.receiver.input;
  LONGS_EQUAL(-2'000, in.motor_speed.value.raw());
  LONGS_EQUAL(4 * 6'542, in.phase_current.value.raw());
  LONGS_EQUAL(503, in.motor_temperature.value.raw());
  LONGS_EQUAL(700, in.inverter_temperature.value.raw());
  CHECK(in.motor_speed.good() && in.phase_current.good() && in.motor_temperature.good());
}

// MST-068, MST-070: the worst of four.
TEST(Amk, OneThatIsBehindTheOthersIsTheStateOfAll) {
  bench.all(enabled_amk());
  bench.run(2);
  CHECK(bench.state_is(InverterState::kEnabled));
  for (std::size_t k = 0; k < kWheels; ++k) {
    bench.all(enabled_amk());
    bench.actual1[k] = dc_on_amk();
    bench.run();
    CHECK(bench.state_is(InverterState::kDisabled));
    bench.actual1[k] = ready_amk();
    bench.run();
    CHECK(bench.state_is(InverterState::kOff));
    bench.actual1[k] = enabled_amk();
    bench.actual1[k].system_ready = false;
    bench.run();
    CHECK(bench.state_is(InverterState::kOff));
    bench.actual1[k].error = true;
    bench.run();
    CHECK(bench.state_is(InverterState::kFault));
  }
}

// MST-070: with three that go on, torque rests on what the fourth said last.
TEST(Amk, SilenceOfOneIsTheAgeOfAllAndAnErrorOfAnotherIsToldAllTheSame) {
  bench.all(enabled_amk());
  bench.run(3);
  bench.silent[2] = true;
  bench.run(4);
  LONGS_EQUAL(40, bench.age_ms());
  CHECK(bench.state_is(InverterState::kEnabled));
  bench.run(5);
  CHECK(bench.receiver.input.inverter_state.good());
  bench.run();
  CHECK_FALSE(bench.receiver.input.inverter_state.good());
  CHECK_FALSE(bench.receiver.input.motor_speed.good());
  bench.actual1[0].error = true;
  bench.run();
  CHECK(bench.state_is(InverterState::kFault));
}

// MST-070: also one that fell silent itself, before the others and after them.
TEST(Amk, AnErrorIsToldWhileAnotherThatHadOneIsSilent) {
  for (std::size_t k = 0; k < kWheels; ++k) {
    AmkBench other;
    other.all(enabled_amk());
    other.actual1[k].error = true;
    other.run(2);
    CHECK(other.state_is(InverterState::kFault));
    other.silent[k] = true;
    other.run(10);
    CHECK_FALSE(other.receiver.input.inverter_state.good());
    other.actual1[(k + 2) % kWheels].error = true;
    other.run();
    CHECK(other.state_is(InverterState::kFault));
  }
}

// MST-068
TEST(Amk, EverySingleBitOfTheSequenceIsAskedFor) {
  CHECK(amk_state(enabled_amk()) == InverterState::kEnabled);
  codec::AmkActual1 m = enabled_amk();
  m.dc_on = false;
  CHECK(amk_state(m) == InverterState::kOff);
  m = enabled_amk();
  m.quit_dc_on = false;
  CHECK(amk_state(m) == InverterState::kOff);
  m = enabled_amk();
  m.inverter_on = false;
  CHECK(amk_state(m) == InverterState::kDisabled);
  m = enabled_amk();
  m.quit_inverter_on = false;
  CHECK(amk_state(m) == InverterState::kDisabled);
}

// MST-060: each motor is watched on its own and believed by its own age, and a clock that wraps makes none young.
TEST(Amk, WhatOneSaidLastGrowsOldAloneAndNeverYoungAgain) {
  for (std::size_t k = 0; k < kWheels; ++k) {
    AmkBench other;
    other.all(enabled_amk());
    other.run(2);
    other.silent[k] = true;
    other.run(60);
    const Input& in = other.receiver.input;
    for (std::size_t wheel = 0; wheel < kWheels; ++wheel) {
      CHECK_EQUAL(wheel != k, in.motors.speed[wheel].good());
      CHECK_EQUAL(wheel != k, in.motors.current[wheel].good());
    }
    CHECK_FALSE(in.motor_temperature.good() || in.inverter_temperature.good());
    other.now = Instant::from_ms(0x8000'0000U + 10'000U);  // 25 days
    other.run(2);
    CHECK_FALSE(in.inverter_state.good() || in.motor_speed.good() || in.phase_current.good());
    CHECK_FALSE(in.motor_temperature.good() || in.inverter_temperature.good());
  }
}

// MST-060
TEST(Amk, AWrongLengthRefreshesNothingAndARepeatedFrameIsAsNew) {
  bench.all(dc_on_amk());
  bench.run(3);
  Frame shorter = wheel_frame(enabled_amk(), 0);
  shorter.dlc = 7;
  bench.receive(shorter);
  CHECK(bench.state_is(InverterState::kDisabled));
  bench.receive(wheel_frame(enabled_amk(), 0));
  bench.receive(wheel_frame(enabled_amk(), 0));
  CHECK(bench.state_is(InverterState::kDisabled));  // the other three are not
}

// MST-034: one that is not known is none that is known.
TEST(Amk, ATemperatureThatOneDoesNotTellIsNotKnown) {
  bench.actual2[3].motor_temperature_dc = -400;
  bench.run(3);
  CHECK_FALSE(bench.receiver.input.motor_temperature.good());
  CHECK(bench.receiver.input.inverter_temperature.good());
}

TEST(Amk, OfAnInverterAndItsTransistorsTheHotterCountsAndBothMustBeKnown) {
  for (codec::AmkActual2& m : bench.actual2) m.inverter_temperature_dc = m.igbt_temperature_dc = 500;
  bench.actual2[1].inverter_temperature_dc = 810;
  bench.run(3);
  const Input& in = bench.receiver.input;
  LONGS_EQUAL(810, in.inverter_temperature.value.raw());
  bench.actual2[2].igbt_temperature_dc = 820;
  bench.run();
  LONGS_EQUAL(820, in.inverter_temperature.value.raw());

  for (std::int32_t codec::AmkActual2::*sensor :
       {&codec::AmkActual2::inverter_temperature_dc, &codec::AmkActual2::igbt_temperature_dc}) {
    const std::int32_t before = bench.actual2[3].*sensor;
    bench.actual2[3].*sensor = -400;  // MST-039: open, beside one that is warm
    bench.run(3);
    CHECK_FALSE(in.inverter_temperature.good());
    bench.actual2[3].*sensor = before;
    bench.run(3);
    CHECK(in.inverter_temperature.good());
  }
  constexpr std::uint8_t kInverter = 2, kIgbt = 6;
  for (const std::uint8_t byte : {kInverter, kIgbt}) {
    Frame frame = wheel_frame(bench.actual2[0], 0);
    frame.data[byte] = 0x01;  // -32767, beyond the signal's range
    frame.data[byte + 1] = 0x80;
    bench.receive(frame);
    CHECK_FALSE(in.inverter_temperature.good());
    bench.run();
    CHECK(in.inverter_temperature.good());
  }
}

TEST(Amk, FramesOfOtherInvertersAreNotHeardNorAreThesesByOthers) {
  Frame ours;
  encode(can::InverterStatus{}, ours);
  bench.receive(ours);
  bench.receive(ours);
  CHECK(bench.receiver.input.dc_link_voltage.quality == Quality::kNone);
  Receiver other{};
  for (int k = 0; k < 5; ++k) {
    bench.now = bench.now + Duration::from_ms(10);
    const Frame frames[] = {wheel_frame(enabled_amk(), 0), wheel_frame(codec::AmkSetpoints{}, 1)};
    ingest(bench.now, FrameView{frames, 2}, other);
  }
  CHECK_FALSE(other.input.motors.speed[0].good());
  CHECK_FALSE(other.input.foreign_frames);
}

TEST(Amk, AFrameThatIsNoneOfTheirsSaysNothing) {
  Frame frame;
  encode(can::PackSensor{}, frame);
  Input in{};
  AmkReading reading{};
  take_amk(frame, reading, in);
  CHECK(in.dc_link_voltage.quality == Quality::kNone && reading.state[0].quality == Quality::kNone);
}

// MST-060: of three protocols each hears its own inverters alone; setpoints are for inverters.
TEST(Amk, WhatIsHeardIsWhatTheCarHas) {
  struct Row {
    std::uint32_t id;
    bool phase_current, pm100, amk;
  };
  const Row rows[] = {{can::InverterStatus::kId, true, false, false},
                      {can::MotorTemperatures::kId, true, false, false},
                      {can::Pm100ModuleTemperatures::kId, false, true, false},
                      {can::Pm100Torque::kId, false, true, false},
                      {can::AmkActual1FrontLeft::kId, false, false, true},
                      {can::AmkActual2RearRight::kId, false, false, true},
                      {can::DcLinkSensor::kId, false, false, true},
                      {can::AmkSetpointsFrontLeft::kId, false, false, false},
                      {can::AmkSetpointsRearRight::kId, false, false, false},
                      {can::Pedals::kId, true, true, true}};
  InverterLink link;
  for (const Row& row : rows) {
    link.protocol = InverterProtocol::kPhaseCurrent;
    CHECK_EQUAL(row.phase_current, is_heard(link, row.id));
    link.protocol = InverterProtocol::kPm100;
    CHECK_EQUAL(row.pm100, is_heard(link, row.id));
    link.protocol = InverterProtocol::kAmk;
    CHECK_EQUAL(row.amk, is_heard(link, row.id));
  }
}

TEST(Amk, ALinkHasTheNumbersOfItsCar) {
  Config config = amk_config();
  config.nominal_torque_mnm = 21'000;
  const InverterLink link = inverter_link(config);
  CHECK(link.protocol == InverterProtocol::kAmk);
  LONGS_EQUAL(260'000, link.motor_constant_unm_per_a);
  LONGS_EQUAL(260'000, link.amk_scale.motor_constant_unm_per_a);
  LONGS_EQUAL(21'000, link.amk_scale.nominal_torque_mnm);
  LONGS_EQUAL(20'000, link.amk_scale.speed_max.raw());
}

TEST(Amk, TheDcLinkIsTheCarsOwnMeasurement) {
  codec::Sealer sealer;
  for (int k = 0; k < 3; ++k) {
    bench.now = bench.now + Duration::from_ms(10);
    can::DcLinkSensor m;
    m.dc_link_voltage_100uv = 5'000'000;
    m.dc_link_voltage_ok = true;
    Frame frame;
    encode(m, frame);
    sealer.seal(frame);
    bench.receive(frame);
  }
  LONGS_EQUAL(5'000'000, bench.receiver.input.dc_link_voltage.value.raw());
}

// MST-071
TEST(Amk, DrivingHasTheHighestSpeedAndAPositiveLimitBrakingNoSpeedAndANegativeOne) {
  const codec::AmkSetpoints drive = sent(enabled(40'000), 0);  // 10.4 Nm
  LONGS_EQUAL(20'000, drive.target_velocity_rpm);
  LONGS_EQUAL(1'061'000, drive.torque_limit_positive_ppm);
  LONGS_EQUAL(0, drive.torque_limit_negative_ppm);
  const codec::AmkSetpoints brake = sent(enabled(-40'000), 0);
  LONGS_EQUAL(0, brake.target_velocity_rpm);
  LONGS_EQUAL(0, brake.torque_limit_positive_ppm);
  LONGS_EQUAL(-1'061'000, brake.torque_limit_negative_ppm);
}

// MST-071: also what stands in a state that may not be.
TEST(Amk, WithoutEnableEverySetpointIsZeroWhateverTheCurrents) {
  Output out = enabled(40'000);
  out.enable = false;
  const codec::AmkSetpoints m = sent(out, 2);
  CHECK(m.dc_on && !m.enable && !m.inverter_on);
  LONGS_EQUAL(0, m.target_velocity_rpm);
  LONGS_EQUAL(0, m.torque_limit_positive_ppm);
}

// MST-071
TEST(Amk, TorqueIsCutTowardsZeroWhateverIsDrawn) {
  const unsigned seed = std::random_device{}();
  std::mt19937 draw(seed);
  for (int k = 0; k < 100'000; ++k) {
    const std::int32_t ma = std::uniform_int_distribution<std::int32_t>(-400'000, 400'000)(draw);
    const codec::AmkSetpoints m = sent(enabled(ma), k % kWheels);
    const std::int64_t ppm = std::int64_t{m.torque_limit_positive_ppm} + m.torque_limit_negative_ppm;
    const std::int64_t exact = std::int64_t{ma} * 260'000 / 9'800;
    const std::int64_t left = ma >= 0 ? exact - ppm : ppm - exact;
    if (left < 0 || left > 1'000) FAIL("not the torque that was asked for");
    CHECK(m.torque_limit_positive_ppm >= 0 && m.torque_limit_negative_ppm <= 0);
    CHECK(m.target_velocity_rpm == 0 || m.torque_limit_negative_ppm == 0);
  }
}

// MST-071: beyond what the signal can say it is its end, also with the smallest nominal torque.
TEST(Amk, ATorqueThatTheSignalCannotSayIsItsEnd) {
  AmkScale scale{260'000, 800, MotorSpeed::from_raw(20'000)};
  LONGS_EQUAL(32'500'000, amk_setpoints(enabled(100'000), 0, scale).torque_limit_positive_ppm);
  LONGS_EQUAL(32'767'000, amk_setpoints(enabled(101'000), 0, scale).torque_limit_positive_ppm);
  LONGS_EQUAL(-32'500'000, amk_setpoints(enabled(-100'000), 0, scale).torque_limit_negative_ppm);
  LONGS_EQUAL(-32'767'000, amk_setpoints(enabled(-101'000), 0, scale).torque_limit_negative_ppm);
  scale.nominal_torque_mnm = 1;
  LONGS_EQUAL(260'000, amk_setpoints(enabled(1), 0, scale).torque_limit_positive_ppm);
}

// MST-071
TEST(Amk, WithoutANominalTorqueThereIsNone) {
  for (const std::int32_t nominal : {0, -1}) {
    const AmkScale scale{260'000, nominal, MotorSpeed::from_raw(20'000)};
    const codec::AmkSetpoints m = amk_setpoints(enabled(40'000), 0, scale);
    CHECK(m.enable);
    LONGS_EQUAL(0, m.target_velocity_rpm);
    LONGS_EQUAL(0, m.torque_limit_positive_ppm);
    LONGS_EQUAL(0, m.torque_limit_negative_ppm);
  }
}

// MST-074
TEST(Amk, AnErrorIsResetByTheButtonAloneAndWithZeroSetpoints) {
  Output out;
  CHECK_FALSE(sent(out, 0).error_reset);
  out.reset_request = true;
  const codec::AmkSetpoints m = sent(out, 0);
  CHECK(m.error_reset && !m.enable && !m.dc_on);
  LONGS_EQUAL(0, m.torque_limit_positive_ppm);
}

// MST-073
TEST(Amk, SetpointsFromTheBusAreForeignForASecondAtEachOfTheFour) {
  for (std::size_t k = 0; k < kWheels; ++k) {
    AmkBench other;
    other.run(3);
    CHECK_FALSE(other.receiver.input.foreign_frames);
    other.receive(wheel_frame(codec::AmkSetpoints{}, k));
    CHECK(other.receiver.input.foreign_frames);
    other.run(99);
    CHECK(other.receiver.input.foreign_frames);
    other.run();
    CHECK_FALSE(other.receiver.input.foreign_frames);
  }
}

// MST-073: a node that has just begun has heard nobody.
TEST(Amk, NothingIsForeignInTheFirstSecond) {
  bench.now = Instant{};
  bench.run(50);
  CHECK_FALSE(bench.receiver.input.foreign_frames);
}

// MST-073
TEST(Amk, WhatItHasSentItselfIsNotForeignOnceAndNeverLater) {
  codec::Sealer sealer;
  TxQueue tx;
  Output out = enabled(40'000);
  transmit_to_inverter(out, bench.receiver.inverter, sealer, tx);
  LONGS_EQUAL(kWheels, tx.size());
  for (const Frame& frame : tx) bench.receive(frame);
  CHECK_FALSE(bench.receiver.input.foreign_frames);
  bench.receive(tx[3]);
  CHECK(bench.receiver.input.foreign_frames);
}
