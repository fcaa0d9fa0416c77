// SPDX-License-Identifier: Apache-2.0
#include "replay/input_frames.hpp"

#include <algorithm>
#include <cmath>

#include "codec/message_table.hpp"
#include "codec/send.hpp"
#include "core/demand.hpp"

namespace voltlap::plant {
namespace {

constexpr std::int32_t kMild_dc = 250;  // motor and inverter, which no role names: 25 degC
constexpr double kCurrentMost_a = 1000.0, kPhaseMost_a = 700.0, kSpeedMost_rpm = 12000.0;  // of car.dbc
constexpr double kLinkUp = 0.5;         // of the pack's voltage: the inverter is on

/// SI to the codec's integers, to nearest.
std::int32_t to_units(double value, double units_per_si) {
  return static_cast<std::int32_t>(std::lround(std::clamp(value * units_per_si, -2e9, 2e9)));
}

/// A value that its message can carry; else it says that there is none.
bool put(double value, double most, double units_per_si, std::int32_t& field) {
  const bool carried = std::isfinite(value) && std::abs(value) <= most;
  if (carried) field = to_units(value, units_per_si);
  return carried;
}

bool row_due(std::uint32_t id, Instant now) {
  const auto& row = can::kMessages[codec::find_row(can::kMessages, codec::kMessageCount, id)];
  return can::due(now.ms(), row.cycle_ms, row.delay_ms);
}

}  // namespace

InputFrames::InputFrames(std::size_t cells, std::size_t thermistors, const PedalSensors& pedals, Value cell,
                         Value thermistor)
    : cells_(cells),
      thermistors_(thermistors),
      pedals_(pedals),
      cell_(std::move(cell)),
      thermistor_(std::move(thermistor)) {
  VOLTLAP_DEMAND(cells > 0 && cells <= can::CellVoltages::kGroups * can::CellVoltages::kPerFrame);
  VOLTLAP_DEMAND(thermistors > 0 && thermistors <= can::Temperatures::kGroups * can::Temperatures::kPerFrame);
}

void InputFrames::send(Instant now, const Readings& readings, TxQueue& tx) {
  send_pack(readings, tx);
  send_pedals(readings, tx);
  send_wheels(readings, tx);
  send_inverter(readings, tx);
  send_io(readings, tx);
  send_cells(now, tx);
  send_temperatures(now, tx);
  send_motor_temperatures(now, tx);
}

void InputFrames::send_pack(const Readings& r, TxQueue& tx) {
  constexpr double kMost_v = 650.0;
  can::PackSensor m;
  m.pack_current_ok = put(r.current_a, kCurrentMost_a, 1e3, m.pack_current_ma);
  m.pack_voltage_ok = put(r.pack_v, kMost_v, 1e4, m.pack_voltage_100uv);
  codec::send(m, sealer_, tx);
}

void InputFrames::send_pedals(const Readings& r, TxQueue& tx) {
  constexpr double kMost_bar = 160.0;
  const double travel = std::clamp(r.accelerator, 0.0, 1.0);
  can::Pedals m;
  m.apps1_100uv = to_units(pedals_.apps1.voltage(travel), 1e4);
  m.apps2_100uv = to_units(pedals_.apps2.voltage(travel), 1e4);
  m.brake_front_mbar = m.brake_rear_mbar = to_units(std::clamp(r.brake_bar, 0.0, kMost_bar), 1e3);
  m.apps1_ok = m.apps2_ok = m.brake_front_ok = m.brake_rear_ok = true;
  codec::send(m, sealer_, tx);
}

void InputFrames::send_wheels(const Readings& r, TxQueue& tx) {
  constexpr double kMost_mps = 80.0;
  can::WheelSpeeds m;
  m.front_left_ok = put(std::abs(r.wheel_mps[0]), kMost_mps, 1e3, m.front_left_mmps);
  m.front_right_ok = put(std::abs(r.wheel_mps[1]), kMost_mps, 1e3, m.front_right_mmps);
  m.rear_left_ok = put(std::abs(r.wheel_mps[2]), kMost_mps, 1e3, m.rear_left_mmps);
  m.rear_right_ok = put(std::abs(r.wheel_mps[3]), kMost_mps, 1e3, m.rear_right_mmps);
  codec::send(m, sealer_, tx);
}

void InputFrames::send_inverter(const Readings& r, TxQueue& tx) {
  can::InverterStatus m;
  m.motor_speed_ok = put(r.motor_speed_rpm, kSpeedMost_rpm, 1.0, m.motor_speed_rpm);
  m.phase_current_ok = put(r.phase_current_a, kPhaseMost_a, 1e3, m.phase_current_ma);
  m.dc_link_voltage_100uv = to_units(r.dc_link_v, 1e4);
  m.dc_link_voltage_ok = true;
  m.state = r.dc_link_v > kLinkUp * r.pack_v ? can::InverterState::kEnabled : can::InverterState::kOff;
  codec::send(m, sealer_, tx);
}

void InputFrames::send_io(const Readings& r, TxQueue& tx) {
  can::VehicleIo m;
  m.air_plus_aux = r.air_plus;
  m.air_minus_aux = r.air_minus;
  m.precharge_aux = r.precharge;
  m.shutdown_closed = r.switches.shutdown_closed;
  m.ts_on_button = r.switches.ts_on;
  m.rtd_button = r.switches.ready_to_drive;
  m.reset_button = r.switches.reset;
  codec::send(m, sealer_, tx);
}

void InputFrames::send_cells(Instant now, TxQueue& tx) {
  constexpr double kMost_v = 6.5;
  const std::int32_t cycle = can::cell_cycle_ms(cells_);
  for (std::size_t group = 0; group * can::CellVoltages::kPerFrame < cells_; ++group) {
    if (!can::due(now.ms(), cycle, static_cast<std::int32_t>(group * can::kTickMs))) continue;
    can::CellVoltages m;
    m.group = static_cast<std::uint8_t>(group);
    for (std::size_t i = 0; i < can::CellVoltages::kPerFrame; ++i) {
      const std::size_t cell = group * can::CellVoltages::kPerFrame + i;
      m.cell_ok[i] = cell < cells_ && put(cell_(cell), kMost_v, 1e4, m.cell_100uv[i]);
    }
    codec::send(m, sealer_, tx);
  }
}

void InputFrames::send_temperatures(Instant now, TxQueue& tx) {
  constexpr double kMost_c = 125.0;
  for (std::size_t group = 0; group * can::Temperatures::kPerFrame < thermistors_; ++group) {
    if (!row_due(can::Temperatures::kBaseId + static_cast<std::uint32_t>(group), now)) continue;
    can::Temperatures m;
    m.group = static_cast<std::uint8_t>(group);
    for (std::size_t i = 0; i < can::Temperatures::kPerFrame; ++i) {
      const std::size_t sensor = group * can::Temperatures::kPerFrame + i;
      m.temperature_ok[i] = sensor < thermistors_ && put(thermistor_(sensor), kMost_c, 10.0, m.temperature_dc[i]);
    }
    codec::send(m, sealer_, tx);
  }
}

void InputFrames::send_motor_temperatures(Instant now, TxQueue& tx) {
  if (!row_due(can::MotorTemperatures::kId, now)) return;
  can::MotorTemperatures m;
  m.motor_dc = m.inverter_dc = kMild_dc;
  m.motor_ok = m.inverter_ok = true;
  codec::send(m, sealer_, tx);
}

}  // namespace voltlap::plant
