// SPDX-License-Identifier: Apache-2.0
#include "master/ingest.hpp"

#include "base/require.hpp"
#include "codec/refresh.hpp"
#include "master/refresh_temperature.hpp"

namespace voltlap::master {
namespace {

using codec::expire;
using codec::refresh;

void take_pedals(const Frame& frame, Input& in) {
  can::Pedals m;
  if (!decode(frame, m)) return;
  refresh(in.apps1, m.apps1_ok, Potential::from_raw(m.apps1_100uv), in.now);
  refresh(in.apps2, m.apps2_ok, Potential::from_raw(m.apps2_100uv), in.now);
  refresh(in.brake_front, m.brake_front_ok, Pressure::from_raw(m.brake_front_mbar), in.now);
  refresh(in.brake_rear, m.brake_rear_ok, Pressure::from_raw(m.brake_rear_mbar), in.now);
}

void take_wheels(const Frame& frame, Input& in) {
  can::WheelSpeeds m;
  if (!decode(frame, m)) return;
  refresh(in.wheel_speed[0], m.front_left_ok, Speed::from_raw(m.front_left_mmps), in.now);
  refresh(in.wheel_speed[1], m.front_right_ok, Speed::from_raw(m.front_right_mmps), in.now);
  refresh(in.wheel_speed[2], m.rear_left_ok, Speed::from_raw(m.rear_left_mmps), in.now);
  refresh(in.wheel_speed[3], m.rear_right_ok, Speed::from_raw(m.rear_right_mmps), in.now);
}

void take_inverter(const Frame& frame, Input& in) {
  can::InverterStatus m;
  if (!decode(frame, m)) return;
  refresh(in.motor_speed, m.motor_speed_ok, MotorSpeed::from_raw(m.motor_speed_rpm), in.now);
  refresh(in.dc_link_voltage, m.dc_link_voltage_ok, PackVoltage::from_raw(m.dc_link_voltage_100uv), in.now);
  refresh(in.inverter_state, true, m.state, in.now);
  refresh(in.phase_current, m.phase_current_ok, Current::from_raw(m.phase_current_ma), in.now);
}

void take_pack(const Frame& frame, Input& in) {
  can::PackSensor m;
  if (!decode(frame, m)) return;
  refresh(in.pack_current, m.pack_current_ok, Current::from_raw(m.pack_current_ma), in.now);
  refresh(in.pack_voltage, m.pack_voltage_ok, PackVoltage::from_raw(m.pack_voltage_100uv), in.now);
}

void take_switches(const Frame& frame, Input& in) {
  can::VehicleIo m;
  if (!decode(frame, m)) return;
  const bool closed = m.shutdown_closed && !m.interlock_open;  // BMS-037
  refresh(in.switches, true, Switches{closed, m.ts_on_button, m.rtd_button, m.reset_button}, in.now);
}

// A limit without a reason is no limit that a BMS has computed: all-zero data allows nothing.
void take_limits(const Frame& frame, Input& in) {
  can::BmsLimits m;
  if (!decode(frame, m)) return;
  const bool discharge_ok = m.discharge_limit_ok && m.discharge_reason != can::LimitReason::kNone;
  const bool charge_ok = m.charge_limit_ok && m.charge_reason != can::LimitReason::kNone;
  refresh(in.discharge_limit, discharge_ok, Current::from_raw(m.discharge_limit_ma), in.now);
  refresh(in.charge_limit, charge_ok, Current::from_raw(m.charge_limit_ma), in.now);
}

void take_bms_status(const Frame& frame, Input& in) {
  can::BmsStatus m;
  if (!decode(frame, m)) return;
  refresh(in.bms_state, m.state != BmsState::kInvalid, m.state, in.now);
  constexpr auto kForeign = static_cast<unsigned>(can::BmsFault::kForeignFrames);
  in.bms_hears_foreign = (m.faults >> kForeign & 1U) != 0;
}

void take_temperatures(const Frame& frame, Input& in) {
  can::MotorTemperatures m;
  if (!decode(frame, m)) return;
  refresh_temperature(in.motor_temperature, m.motor_ok, m.motor_dc, in.now);
  refresh_temperature(in.inverter_temperature, m.inverter_ok, m.inverter_dc, in.now);
}

// Frames of the inverters of other makers.
void take_others(const Frame& frame, InverterLink& link, Input& in) {
  if (is_pm100(frame.id)) return take_pm100(frame, link.motor_constant_unm_per_a, link.pm100, in);
  take_amk(frame, link.amk, in);
}

void take_frame(const Frame& frame, Receiver& receiver) {
  Input& in = receiver.input;
  switch (frame.id) {
    case can::Pedals::kId: return take_pedals(frame, in);
    case can::WheelSpeeds::kId: return take_wheels(frame, in);
    case can::InverterStatus::kId: return take_inverter(frame, in);
    case can::PackSensor::kId: return take_pack(frame, in);
    case can::VehicleIo::kId: return take_switches(frame, in);
    case can::BmsLimits::kId: return take_limits(frame, in);
    case can::BmsStatus::kId: return take_bms_status(frame, in);
    case can::MotorTemperatures::kId: return take_temperatures(frame, in);
    default: return take_others(frame, receiver.inverter, in);
  }
}

void expire_all(Input& in) {
  expire(in.apps1, can::Pedals::kTimeoutMs, in.now);
  expire(in.apps2, can::Pedals::kTimeoutMs, in.now);
  expire(in.brake_front, can::Pedals::kTimeoutMs, in.now);
  expire(in.brake_rear, can::Pedals::kTimeoutMs, in.now);
  for (Sample<Speed>& wheel : in.wheel_speed) expire(wheel, can::WheelSpeeds::kTimeoutMs, in.now);
  expire(in.motor_speed, can::InverterStatus::kTimeoutMs, in.now);
  expire(in.dc_link_voltage, can::InverterStatus::kTimeoutMs, in.now);
  expire(in.inverter_state, can::InverterStatus::kTimeoutMs, in.now);
  expire(in.phase_current, can::InverterStatus::kTimeoutMs, in.now);
  expire(in.pack_current, can::PackSensor::kTimeoutMs, in.now);
  expire(in.pack_voltage, can::PackSensor::kTimeoutMs, in.now);
  expire(in.switches, can::VehicleIo::kTimeoutMs, in.now);
  expire(in.discharge_limit, can::BmsLimits::kTimeoutMs, in.now);
  expire(in.charge_limit, can::BmsLimits::kTimeoutMs, in.now);
  expire(in.bms_state, can::BmsStatus::kTimeoutMs, in.now);
  expire(in.motor_temperature, can::MotorTemperatures::kTimeoutMs, in.now);
  expire(in.inverter_temperature, can::MotorTemperatures::kTimeoutMs, in.now);
}

}  // namespace

// MST-060: a missing, late, repeated, damaged, foreign or impossible frame refreshes nothing.
void ingest(Instant now, FrameView frames, Receiver& receiver) {
  VOLTLAP_REQUIRE(frames.count == 0 || frames.first != nullptr);
  receiver.input.now = now;
  for (const Frame& frame : frames) {
    note_foreign_command(frame, now, receiver.inverter);
    if (!is_heard(receiver.inverter, frame.id)) continue;
    if (receiver.rx.receive(frame, now) == codec::RxVerdict::kAccepted) take_frame(frame, receiver);
  }
  receiver.rx.expire(now);
  settle_pm100(receiver.inverter.pm100, receiver.input);
  if (receiver.inverter.protocol == InverterProtocol::kAmk) settle_amk(receiver.inverter.amk, receiver.input);
  receiver.input.foreign_frames =
      receiver.rx.contested() || receiver.inverter.pm100.foreign || receiver.inverter.amk.foreign;
  expire_all(receiver.input);
}

}  // namespace voltlap::master
