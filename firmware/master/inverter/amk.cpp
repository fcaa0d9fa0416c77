// SPDX-License-Identifier: Apache-2.0
#include "master/inverter/amk.hpp"

#include "base/require.hpp"
#include "codec/amk_motors.hpp"
#include "codec/refresh.hpp"
#include "master/refresh_temperature.hpp"

namespace voltlap::master {
namespace {

using codec::expire;
using codec::refresh;

constexpr std::int32_t kForeign_ms = 1'000;
constexpr std::int64_t kStepPpm = 1'000;         // 0.1 %
constexpr std::int64_t kMostPpm = 32'767'000;    // of the signal

// The one that may do less, of two that are not in error.
InverterState worse(InverterState a, InverterState b) {
  if (a == InverterState::kEnabled) return b;
  return a == InverterState::kDisabled && b != InverterState::kEnabled ? b : a;
}
Temperature hotter(Temperature a, Temperature b) { return max(a, b); }

// An error of one is told at once, also while another is silent.
const Sample<InverterState>* in_error(const AmkReading& reading) {
  for (const Sample<InverterState>& state : reading.state) {
    if (state.good() && state.value == InverterState::kFault) return &state;
  }
  return nullptr;
}

void take_actual2(const codec::AmkActual2& m, std::size_t wheel, AmkReading& reading, Instant now) {
  refresh_temperature(reading.motor[wheel], m.motor_temperature_ok, m.motor_temperature_dc, now);
  refresh_hottest(reading.inverter[wheel], m.inverter_temperature_ok && m.igbt_temperature_ok, now,
                  m.inverter_temperature_dc, m.igbt_temperature_dc);
}

std::int64_t torque_ppm(Current current, const AmkScale& scale) {
  if (scale.nominal_torque_mnm <= 0) return 0;
  const std::int64_t nnm = std::int64_t{current.raw()} * scale.motor_constant_unm_per_a;  // mA uNm/A
  const std::int64_t ppm = nnm / scale.nominal_torque_mnm / kStepPpm * kStepPpm;
  return max(min(ppm, kMostPpm), -kMostPpm);
}

}  // namespace

InverterState amk_state(const codec::AmkActual1& m) {
  if (m.error) return InverterState::kFault;
  if (!m.system_ready || !m.dc_on || !m.quit_dc_on) return InverterState::kOff;
  return m.inverter_on && m.quit_inverter_on ? InverterState::kEnabled : InverterState::kDisabled;
}

void take_amk(const Frame& frame, AmkReading& reading, Input& in) {
  std::size_t wheel = 0;
  codec::AmkActual1 actual1;
  codec::AmkActual2 actual2;
  can::DcLinkSensor dc_link;
  if (codec::decode_amk(frame, wheel, actual1)) {
    codec::take_motor(actual1, wheel, in.now, in.motors);
    refresh(reading.state[wheel], true, amk_state(actual1), in.now);
  } else if (codec::decode_amk(frame, wheel, actual2)) {
    take_actual2(actual2, wheel, reading, in.now);
  } else if (decode(frame, dc_link)) {
    refresh(in.dc_link_voltage, dc_link.dc_link_voltage_ok, PackVoltage::from_raw(dc_link.dc_link_voltage_100uv),
            in.now);
  }
}

// MST-070: silent, in error or not ready: of four the worst counts.
void settle_amk(AmkReading& reading, Input& in) {
  codec::expire_motors(in.motors, in.now);
  for (Sample<InverterState>& state : reading.state) expire(state, codec::AmkActual1::kTimeoutMs, in.now);
  for (Sample<Temperature>& motor : reading.motor) expire(motor, codec::AmkActual2::kTimeoutMs, in.now);
  for (Sample<Temperature>& inverter : reading.inverter) expire(inverter, codec::AmkActual2::kTimeoutMs, in.now);
  const Sample<InverterState>* error = in_error(reading);
  in.inverter_state = error != nullptr ? *error : codec::joined(reading.state, in.now, worse);
  in.motor_speed = codec::fastest(in.motors, in.now);
  in.phase_current = codec::current_of_all(in.motors, in.now);
  in.motor_temperature = codec::joined(reading.motor, in.now, hotter);
  in.inverter_temperature = codec::joined(reading.inverter, in.now, hotter);
  // MST-073: nobody but this node sends setpoints, and no node hears itself.
  reading.foreign = reading.foreign && (in.now - reading.foreign_at).ms() < kForeign_ms;
}

// MST-071, MST-074
codec::AmkSetpoints amk_setpoints(const Output& output, std::size_t wheel, const AmkScale& scale) {
  codec::AmkSetpoints m;
  m.target_velocity_ok = m.torque_limit_positive_ok = m.torque_limit_negative_ok = true;
  m.error_reset = output.reset_request;
  m.dc_on = output.dc_on;
  m.enable = m.inverter_on = output.enable;
  if (!output.enable) return m;
  const std::int64_t ppm = torque_ppm(output.wheel.of[wheel], scale);
  if (ppm > 0) {
    m.target_velocity_rpm = scale.speed_max.raw();
    m.torque_limit_positive_ppm = static_cast<std::int32_t>(ppm);
  } else {
    m.torque_limit_negative_ppm = static_cast<std::int32_t>(ppm);
  }
  VOLTLAP_REQUIRE(m.dc_on && m.torque_limit_negative_ppm <= 0 && m.torque_limit_positive_ppm >= 0);
  return m;
}

}  // namespace voltlap::master
