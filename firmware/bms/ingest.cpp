// SPDX-License-Identifier: Apache-2.0
#include "bms/ingest.hpp"

#include "base/require.hpp"
#include "codec/refresh.hpp"

namespace voltlap::bms {
namespace {

using codec::expire;
using codec::refresh;

void take_cells(const Config& config, const can::CellVoltages& m, Instant now, Measured& out) {
  for (std::size_t i = 0; i < can::CellVoltages::kPerFrame; ++i) {
    const std::size_t cell = m.group * can::CellVoltages::kPerFrame + i;
    if (cell >= config.cells_in_series) return;
    const CellVoltage voltage = CellVoltage::from_raw(m.cell_100uv[i]);
    const bool plausible = config.cell_voltage_plausible_min <= voltage && voltage <= config.cell_voltage_plausible_max;
    refresh(out.cell[cell], m.cell_ok[i] && plausible, voltage, now);
  }
}

void take_temperatures(const Config& config, const can::Temperatures& m, Instant now, Measured& out) {
  for (std::size_t i = 0; i < can::Temperatures::kPerFrame; ++i) {
    const std::size_t sensor = m.group * can::Temperatures::kPerFrame + i;
    if (sensor >= config.temperature_sensors) return;
    refresh(out.temperature[sensor], m.temperature_ok[i], Temperature::from_raw(m.temperature_dc[i]), now);
  }
}

void take_frame(const Config& config, const Frame& frame, Instant now, Measured& out) {
  can::CellVoltages cells;
  can::Temperatures temperatures;
  can::PackSensor pack;
  can::InverterStatus inverter;
  can::VehicleIo io;
  can::MasterStatus master;
  if (can::decode(frame, cells)) {
    take_cells(config, cells, now, out);
  } else if (can::decode(frame, pack)) {
    refresh(out.current, pack.pack_current_ok, Current::from_raw(pack.pack_current_ma), now);
    refresh(out.pack_voltage, pack.pack_voltage_ok, PackVoltage::from_raw(pack.pack_voltage_100uv), now);
  } else if (can::decode(frame, inverter)) {
    const auto dc_link = PackVoltage::from_raw(inverter.dc_link_voltage_100uv);
    refresh(out.dc_link_voltage, inverter.dc_link_voltage_ok, dc_link, now);
  } else if (can::decode(frame, io)) {
    refresh(out.io, true, VehicleIo{io.air_plus_aux, io.air_minus_aux, io.precharge_aux, io.shutdown_closed}, now);
  } else if (can::decode(frame, master)) {
    const bool known = master.drive_state != can::DriveState::kInvalid;
    refresh(out.master, known, MasterRequest{master.ts_request, master.reset_request}, now);
  } else if (can::decode(frame, temperatures)) {
    take_temperatures(config, temperatures, now, out);
  }
}

void expire_all(const Config& config, Instant now, Measured& out) {
  for (std::size_t i = 0; i < config.cells_in_series; ++i) expire(out.cell[i], can::CellVoltages::kTimeoutMs, now);
  for (std::size_t i = 0; i < config.temperature_sensors; ++i) {
    expire(out.temperature[i], can::Temperatures::kTimeoutMs, now);
  }
  expire(out.current, can::PackSensor::kTimeoutMs, now);
  expire(out.pack_voltage, can::PackSensor::kTimeoutMs, now);
  expire(out.dc_link_voltage, can::InverterStatus::kTimeoutMs, now);
  expire(out.io, can::VehicleIo::kTimeoutMs, now);
  expire(out.master, can::MasterStatus::kTimeoutMs, now);
}

/// A cell's voltage belongs to the current that flowed when it was taken, whatever the order of the frames.
void pair_cells_with_current(const Config& config, Instant now, Measured& out) {
  for (std::size_t i = 0; i < config.cells_in_series; ++i) {
    if (out.cell[i].good() && (now - out.cell[i].time).ms() == 0) out.cell_current[i] = out.current.value;
  }
}

}  // namespace

// BMS-001: a missing, late, repeated, damaged, foreign or impossible sample refreshes nothing.
void ingest(const Config& config, const Input& input, State& state) {
  VOLTLAP_REQUIRE(input.frames.count == 0 || input.frames.first != nullptr);
  VOLTLAP_REQUIRE(config.cells_in_series <= kMaxCells && config.temperature_sensors <= kMaxTemperatures);
  for (const Frame& frame : input.frames) {
    if (state.rx.receive(frame, input.now, config.cells_in_series) == codec::RxVerdict::kAccepted) {
      take_frame(config, frame, input.now, state.measured);
    }
  }
  state.rx.expire(input.now, config.cells_in_series);
  expire_all(config, input.now, state.measured);
  pair_cells_with_current(config, input.now, state.measured);
}

}  // namespace voltlap::bms
