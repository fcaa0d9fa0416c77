// SPDX-License-Identifier: Apache-2.0
#include "master/inverter/pm100.hpp"

#include "base/require.hpp"
#include "codec/refresh.hpp"
#include "master/refresh_temperature.hpp"

namespace voltlap::master {
namespace {

using codec::expire;
using codec::refresh;

constexpr std::uint16_t kCommandLost = 1U << 11;  // of RunLow
constexpr std::int32_t kTorqueStep_mnm = 100;
constexpr std::int32_t kForeign_ms = 1'000;

std::int32_t torque_of(Current current, std::int32_t unm_per_a) {
  const std::int64_t mnm = std::int64_t{current.raw()} * unm_per_a / 1'000'000;  // mA uNm/A are nNm
  return static_cast<std::int32_t>(mnm / kTorqueStep_mnm * kTorqueStep_mnm);
}

Current current_of(std::int32_t torque_mnm, std::int32_t unm_per_a) {
  if (unm_per_a == 0) return Current{};
  return Current::saturated(std::int64_t{torque_mnm} * 1'000'000 / unm_per_a);
}

void take_modules(const can::Pm100ModuleTemperatures& m, Input& in) {
  refresh_hottest(in.inverter_temperature, m.module_a_ok && m.module_b_ok && m.module_c_ok, in.now, m.module_a_dc,
                  m.module_b_dc, m.module_c_dc);
}

}  // namespace

// The time-out of the command has a bit of its own among the run faults; with any other beside it, it is a fault.
Pm100Fault pm100_fault(const can::Pm100Faults& words) {
  if (words.post_low != 0 || words.post_high != 0) return Pm100Fault::kPost;
  if (words.run_low == 0 && words.run_high == 0) return Pm100Fault::kNone;
  return words.run_low == kCommandLost && words.run_high == 0 ? Pm100Fault::kCommandLost : Pm100Fault::kRun;
}

// MST-063: one that is locked out counts as off, so it is sent nothing but a disabled command, which ends the lockout.
InverterState pm100_state(const Pm100Flags& flags, Pm100Fault fault) {
  if (fault == Pm100Fault::kPost || fault == Pm100Fault::kRun) return InverterState::kFault;
  if (fault == Pm100Fault::kCommandLost) return InverterState::kCommandTimeout;
  if (flags.lockout) return InverterState::kOff;
  return flags.enabled ? InverterState::kEnabled : InverterState::kDisabled;
}

void take_pm100(const Frame& frame, std::int32_t unm_per_a, Pm100Reading& reading, Input& in) {
  can::Pm100ModuleTemperatures modules;
  can::Pm100MotorTemperatures motor;
  can::Pm100MotorPosition position;
  can::Pm100Currents currents;
  can::Pm100Voltages voltages;
  can::Pm100States states;
  can::Pm100Faults faults;
  can::Pm100Torque torque;
  if (decode(frame, modules)) {
    take_modules(modules, in);
  } else if (decode(frame, motor)) {
    refresh_temperature(in.motor_temperature, motor.motor_ok, motor.motor_dc, in.now);
  } else if (decode(frame, position)) {
    refresh(in.motor_speed, position.motor_speed_ok, MotorSpeed::from_raw(position.motor_speed_rpm), in.now);
  } else if (decode(frame, currents)) {
    refresh(in.inverter_dc_current, currents.dc_current_ok, Current::from_raw(currents.dc_current_ma), in.now);
  } else if (decode(frame, voltages)) {
    refresh(in.dc_link_voltage, voltages.dc_voltage_ok && voltages.dc_voltage_100uv >= 0,
            PackVoltage::from_raw(voltages.dc_voltage_100uv), in.now);
  } else if (decode(frame, states)) {
    refresh(reading.flags, true, Pm100Flags{states.enabled, states.lockout}, in.now);
  } else if (decode(frame, faults)) {
    refresh(reading.fault, true, pm100_fault(faults), in.now);
  } else if (decode(frame, torque)) {
    refresh(in.phase_current, torque.feedback_ok, current_of(torque.feedback_mnm, unm_per_a), in.now);
    reading.alive = true;
  }
}

void settle_pm100(Pm100Reading& reading, Input& in) {
  expire(reading.flags, can::Pm100States::kTimeoutMs, in.now);
  expire(reading.fault, can::Pm100Faults::kTimeoutMs, in.now);
  expire(in.inverter_dc_current, can::Pm100Currents::kTimeoutMs, in.now);
  if (reading.alive && reading.flags.good() && reading.fault.good()) {
    refresh(in.inverter_state, true, pm100_state(reading.flags.value, reading.fault.value), in.now);
  }
  reading.alive = false;
  // MST-067: nobody but this node sends its command, and no node hears itself.
  reading.foreign = reading.foreign && (in.now - reading.foreign_at).ms() < kForeign_ms;
}

can::Pm100Command pm100_command(const Output& output, std::int32_t unm_per_a, std::uint8_t counter) {
  can::Pm100Command m;
  m.enable = output.enable;
  m.forward = true;  // braking is a negative torque, never another direction
  m.rolling_counter = counter & 0xFU;
  m.torque_ok = m.speed_ok = m.torque_limit_ok = true;
  if (!output.enable) return m;
  m.torque_mnm = torque_of(output.phase_current, unm_per_a);
  m.torque_limit_mnm = max(torque_of(output.current_limit, unm_per_a), kTorqueStep_mnm);
  VOLTLAP_REQUIRE(-m.torque_limit_mnm <= m.torque_mnm && m.torque_mnm <= m.torque_limit_mnm);
  return m;
}

}  // namespace voltlap::master
