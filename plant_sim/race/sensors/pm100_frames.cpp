// SPDX-License-Identifier: Apache-2.0
#include "race/sensors/pm100_frames.hpp"

#include "can_dbc/pm100.hpp"
#include "codec/send.hpp"
#include "race/sensors/frame_units.hpp"

namespace voltlap::plant {
namespace {

void send_slow(Instant now, const Car& car, const Pm100Readings& r, codec::Sealer& sealer, TxQueue& tx) {
  if (row_due(can::Pm100ModuleTemperatures::kId, now)) {
    can::Pm100ModuleTemperatures m;
    m.module_a_dc = m.module_b_dc = m.module_c_dc = m.gate_driver_dc = to_units(r.inverter_c, 10.0);
    codec::send(m, sealer, tx);
  }
  if (row_due(can::Pm100MotorTemperatures::kId, now)) {
    can::Pm100MotorTemperatures m;
    m.motor_dc = to_units(r.motor_c, 10.0);
    codec::send(m, sealer, tx);
  }
  if (row_due(can::Pm100States::kId, now)) {
    can::Pm100States m;
    m.enabled = car.pm100.enabled();
    m.lockout = car.pm100.locked();
    codec::send(m, sealer, tx);
  }
  if (row_due(can::Pm100Faults::kId, now)) {
    can::Pm100Faults m;
    m.post_low = car.pm100.post_low();
    m.run_low = car.pm100.run_low();
    codec::send(m, sealer, tx);
  }
}

}  // namespace

void send_pm100(Instant now, const Car& car, const Pm100Readings& r, codec::Sealer& sealer, TxQueue& tx) {
  can::Pm100MotorPosition position;
  position.motor_speed_rpm = to_units(r.motor_speed_rpm, 1.0);
  codec::send(position, sealer, tx);
  can::Pm100Currents currents;
  currents.dc_current_ma = to_units(r.dc_current_a, 1e3);
  codec::send(currents, sealer, tx);
  can::Pm100Voltages voltages;
  voltages.dc_voltage_100uv = to_units(r.dc_link_v, 1e4);
  codec::send(voltages, sealer, tx);
  can::Pm100Torque torque;
  torque.commanded_mnm = to_units(car.pm100.torque_nm(), 1e3);
  torque.feedback_mnm = to_units(r.phase_current_a * car.parameters().motor.constant_nm_per_a, 1e3);
  codec::send(torque, sealer, tx);
  send_slow(now, car, r, sealer, tx);
}

}  // namespace voltlap::plant
