// SPDX-License-Identifier: Apache-2.0
#include "bms/ingest.hpp"

#include "base/require.hpp"
#include "can_dbc/charger.hpp"
#include "can_dbc/pm100.hpp"
#include "codec/refresh.hpp"

namespace voltlap::bms {
namespace {

using codec::expire;
using codec::refresh;

constexpr Temperature kThermistorOpen = Temperature::from_raw(-390);  // 1 K inside the range of the message, -40 degC
constexpr Temperature kThermistorShort = Temperature::from_raw(1'200);  // 5 K inside it, 125 degC

void take_cells(const Config& config, const can::CellVoltages& m, Instant now, Measured& out) {
  out.arrived |= std::uint64_t{1} << m.group;
  for (std::size_t i = 0; i < can::CellVoltages::kPerFrame; ++i) {
    const std::size_t cell = m.group * can::CellVoltages::kPerFrame + i;
    if (cell >= config.cells_in_series) return;
    const CellVoltage voltage = CellVoltage::from_raw(m.cell_100uv[i]);
    const bool plausible = config.cell_voltage_plausible_min <= voltage && voltage <= config.cell_voltage_plausible_max;
    refresh(out.cell[cell], m.cell_ok[i] && plausible, voltage, now);
  }
}

// BMS-065: the ends of the range are an open and a shorted thermistor, no temperatures.
bool inside_ends(Temperature t) { return kThermistorOpen < t && t < kThermistorShort; }

void take_temperatures(const Config& config, const can::Temperatures& m, Instant now, Measured& out) {
  out.temperatures_arrived = true;
  for (std::size_t i = 0; i < can::Temperatures::kPerFrame; ++i) {
    const std::size_t sensor = m.group * can::Temperatures::kPerFrame + i;
    if (sensor >= config.temperature_sensors) return;
    const Temperature temperature = Temperature::from_raw(m.temperature_dc[i]);
    refresh(out.temperature[sensor], m.temperature_ok[i] && inside_ends(temperature), temperature, now);
  }
}

// Cells that were read before the pack's channel was belong to what it says first: nothing flows at power-on.
void pair_with_first(const Config& config, Measured& out) {
  for (std::size_t i = 0; i < config.cells_in_series; ++i) out.cell_pack[i] = out.pack_voltage.value;
}

void take_pack(const Config& config, const can::PackSensor& m, Instant now, State& state) {
  const Current raw = Current::from_raw(m.pack_current_ma);
  if (m.pack_current_ok) learn_current_offset(raw, now, state);
  refresh(state.measured.current, m.pack_current_ok, raw - state.current_check.offset, now);
  const bool first = state.measured.pack_voltage.time.ms() == 0 && !state.measured.pack_voltage.good();
  refresh(state.measured.pack_voltage, m.pack_voltage_ok, PackVoltage::from_raw(m.pack_voltage_100uv), now);
  if (first && state.measured.pack_voltage.good()) pair_with_first(config, state.measured);
}

void take_inverter(const can::InverterStatus& m, Instant now, Measured& out) {
  refresh(out.dc_link_voltage, m.dc_link_voltage_ok, PackVoltage::from_raw(m.dc_link_voltage_100uv), now);
  refresh(out.phase_current, m.phase_current_ok, Current::from_raw(m.phase_current_ma), now);
  refresh(out.motor_speed, m.motor_speed_ok, MotorSpeed::from_raw(m.motor_speed_rpm), now);
}

// Torque as the phase current that gives it.
void take_pm100(const Config& config, const Frame& frame, Instant now, Measured& out) {
  can::Pm100MotorPosition position;
  can::Pm100Voltages voltages;
  can::Pm100Torque torque;
  if (can::decode(frame, voltages)) {
    refresh(out.dc_link_voltage, voltages.dc_voltage_ok && voltages.dc_voltage_100uv >= 0,
            PackVoltage::from_raw(voltages.dc_voltage_100uv), now);
  } else if (can::decode(frame, position)) {
    refresh(out.motor_speed, position.motor_speed_ok, MotorSpeed::from_raw(position.motor_speed_rpm), now);
  } else if (can::decode(frame, torque) && config.motor_constant_unm_per_a > 0) {
    const std::int64_t ma = std::int64_t{torque.feedback_mnm} * 1'000'000 / config.motor_constant_unm_per_a;
    refresh(out.phase_current, torque.feedback_ok, Current::saturated(ma), now);
  }
}

// Of four motors what stands for all.
void take_amk(const Frame& frame, Instant now, Measured& out) {
  std::size_t wheel = 0;
  codec::AmkActual1 motor;
  can::DcLinkSensor dc_link;
  if (codec::decode_amk(frame, wheel, motor)) {
    codec::take_motor(motor, wheel, now, out.motors);
  } else if (can::decode(frame, dc_link)) {
    refresh(out.dc_link_voltage, dc_link.dc_link_voltage_ok, PackVoltage::from_raw(dc_link.dc_link_voltage_100uv), now);
  }
}

void settle_amk(Instant now, Measured& out) {
  codec::expire_motors(out.motors, now);
  out.phase_current = codec::current_of_all(out.motors, now);
  out.motor_speed = codec::fastest(out.motors, now);
}

// BMS-037: an open interlock is an open shutdown circuit, whatever that one's own line says.
VehicleIo as_reported(const can::VehicleIo& io) {
  return {io.air_plus_aux,
          io.air_minus_aux,
          io.precharge_aux,
          io.shutdown_closed && !io.interlock_open,
          io.charge_switch,
          io.interlock_open,
          io.isolation_fault};
}

void take_charger(const can::ChargerStatus& m, Instant now, Measured& out) {
  const bool faulty = m.hardware_failure || m.over_temperature || m.input_voltage_wrong;
  const bool not_connected = m.battery_not_connected || m.communication_timeout;
  refresh(out.charger, true, ChargerReport{Current::from_raw(m.output_current_ma), faulty, not_connected}, now);
}

void take_frame(const Config& config, const Frame& frame, Instant now, State& state) {
  Measured& out = state.measured;
  can::CellVoltages cells;
  can::Temperatures temperatures;
  can::PackSensor pack;
  can::InverterStatus inverter;
  can::VehicleIo io;
  can::MasterStatus master;
  can::ChargerStatus charger;
  if (can::decode(frame, cells)) {
    take_cells(config, cells, now, out);
  } else if (can::decode(frame, pack)) {
    take_pack(config, pack, now, state);
  } else if (config.inverter_protocol == InverterProtocol::kPhaseCurrent && can::decode(frame, inverter)) {
    take_inverter(inverter, now, out);
  } else if (can::decode(frame, io)) {
    refresh(out.io, true, as_reported(io), now);
  } else if (can::decode(frame, master)) {
    const bool known = master.drive_state != can::DriveState::kInvalid;
    refresh(out.master, known, MasterRequest{master.ts_request, master.reset_request}, now);
  } else if (can::decode(frame, temperatures)) {
    take_temperatures(config, temperatures, now, out);
  } else if (can::decode(frame, charger)) {
    take_charger(charger, now, out);
  } else if (config.inverter_protocol == InverterProtocol::kPm100) {
    take_pm100(config, frame, now, out);
  } else if (config.inverter_protocol == InverterProtocol::kAmk) {
    take_amk(frame, now, out);
  }
}

void expire_all(const Config& config, Instant now, Measured& out) {
  for (std::size_t i = 0; i < config.cells_in_series; ++i) expire(out.cell[i], can::CellVoltages::kTimeoutMs, now);
  for (std::size_t i = 0; i < config.temperature_sensors; ++i) {
    expire(out.temperature[i], can::Temperatures::kTimeoutMs, now);
  }
  expire(out.current, can::PackSensor::kTimeoutMs, now);
  expire(out.pack_voltage, can::PackSensor::kTimeoutMs, now);
  expire(out.phase_current, can::InverterStatus::kTimeoutMs, now);
  expire(out.motor_speed, can::InverterStatus::kTimeoutMs, now);
  expire(out.dc_link_voltage, can::InverterStatus::kTimeoutMs, now);
  expire(out.io, can::VehicleIo::kTimeoutMs, now);
  expire(out.master, can::MasterStatus::kTimeoutMs, now);
  expire(out.charger, can::ChargerStatus::kTimeoutMs, now);
}

/// A cell's voltage belongs to the current that flowed when it was taken, whatever the order of the frames.
void pair_cells_with_current(const Config& config, Measured& out) {
  for_each_arrived(config, out, [&](std::size_t i) {
    if (!out.cell[i].good()) return;
    out.cell_current[i] = out.current.value;
    out.cell_pack[i] = out.pack_voltage.value;
  });
}

}  // namespace

// BMS-001: a missing, late, repeated, damaged, foreign or impossible sample refreshes nothing.
void ingest(const Config& config, const Input& input, State& state) {
  VOLTLAP_REQUIRE(input.frames.count == 0 || input.frames.first != nullptr);
  VOLTLAP_REQUIRE(config.cells_in_series <= kMaxCells && config.temperature_sensors <= kMaxTemperatures);
  state.measured.arrived = 0;
  state.measured.temperatures_arrived = false;
  for (const Frame& frame : input.frames) {
    if (state.rx.receive(frame, input.now, config.cells_in_series) == codec::RxVerdict::kAccepted) {
      take_frame(config, frame, input.now, state);
    }
  }
  state.rx.expire(input.now, config.cells_in_series);
  if (config.inverter_protocol == InverterProtocol::kAmk) settle_amk(input.now, state.measured);
  expire_all(config, input.now, state.measured);
  pair_cells_with_current(config, state.measured);
}

}  // namespace voltlap::bms
