// SPDX-License-Identifier: Apache-2.0
#include "race/sensors/amk_frames.hpp"

#include <algorithm>

#include "codec/send.hpp"
#include "core/demand.hpp"
#include "race/sensors/frame_units.hpp"

namespace voltlap::plant {
namespace {

constexpr double kCurrentCodes = 16384.0 / 107.2;  // a torque current's codes in an ampere

template <class Message>
void send_of(std::size_t wheel, const Message& m, TxQueue& tx) {
  Frame frame;
  codec::encode_amk(m, wheel, frame);
  const bool room = tx.push(frame);
  VOLTLAP_DEMAND(room);
}

codec::AmkActual1 actual1(const Car& car, const AmkReadings& r, std::size_t wheel) {
  const Amk& amk = car.drives[wheel].amk;
  codec::AmkActual1 m;
  m.system_ready = amk.ready();
  m.error = amk.error() != 0;
  m.dc_on = m.quit_dc_on = amk.dc_on();
  m.inverter_on = m.quit_inverter_on = amk.inverter_on();
  m.actual_velocity_rpm = to_units(r.speed_rpm[wheel], 1.0);
  m.actual_velocity_ok = true;
  m.torque_current = static_cast<std::int16_t>(
      std::clamp(to_units(r.current_a[wheel], kCurrentCodes), std::int32_t{-32768}, std::int32_t{32767}));
  return m;
}

codec::AmkActual2 actual2(const Car& car, const AmkReadings& r, std::size_t wheel) {
  codec::AmkActual2 m;
  m.motor_temperature_dc = to_units(r.motor_c[wheel], 10.0);
  m.inverter_temperature_dc = m.igbt_temperature_dc = to_units(r.inverter_c, 10.0);
  m.error_number = car.drives[wheel].amk.error();
  return m;
}

}  // namespace

void send_amk(Instant now, const Car& car, const AmkReadings& r, codec::Sealer& sealer, TxQueue& tx) {
  can::DcLinkSensor dc_link;
  dc_link.dc_link_voltage_100uv = to_units(r.dc_link_v, 1e4);
  dc_link.dc_link_voltage_ok = true;
  codec::send(dc_link, sealer, tx);
  for (std::size_t wheel = 0; wheel < codec::kWheels; ++wheel) send_of(wheel, actual1(car, r, wheel), tx);
  for (std::size_t wheel = 0; wheel < codec::kWheels; ++wheel) {
    if (row_due(codec::AmkIds<codec::AmkActual2>::kId[wheel], now)) send_of(wheel, actual2(car, r, wheel), tx);
  }
}

}  // namespace voltlap::plant
