// SPDX-License-Identifier: Apache-2.0
#include "race/sensors/sensor_frames.hpp"

#include <algorithm>
#include <cmath>

#include "can_dbc/charger.hpp"
#include "codec/send.hpp"
#include "core/demand.hpp"
#include "core/parameter_table.hpp"
#include "race/sensors/frame_units.hpp"
#include "race/sensors/amk_frames.hpp"
#include "race/sensors/pm100_frames.hpp"

namespace voltlap::plant {
namespace {

constexpr double kRpmPerRadPerS = 30.0 / M_PI;

bool rises(const AppsCurve& curve) { return std::isfinite(curve.full_v) && curve.full_v > curve.released_v; }

std::int32_t to_100uv(double volts) { return to_units(volts, 1e4); }
std::int32_t to_ma(double amperes) { return to_units(amperes, 1e3); }
std::int32_t to_dc(double celsius) { return to_units(celsius, 10.0); }

static_assert(can::kTickMs == 10, "kInstrumentPeriod_s is a tick");

std::vector<Instrument> channels(const ReadingErrors& all, const std::vector<ChannelErrors>& single,
                                 std::size_t count) {
  std::vector<Instrument> out;
  for (std::size_t i = 0; i < count; ++i) out.emplace_back(i < single.size() ? single[i].over(all) : all);
  return out;
}

/// Of an instrument without noise that follow_slow has moved.
double shown(const Instrument& instrument, double truth) {
  return instrument.clipped(instrument.scaled(instrument.arrived(truth)));
}

}  // namespace

SensorFrames::SensorFrames(const VehicleParameters& car, std::uint64_t seed, const PedalSensors& pedal_sensors)
    : parameters_(car),
      pedal_sensors_(pedal_sensors),
      sensors_(car.sensors, seed),
      pack_current_(car.sensors.pack_current),
      pack_voltage_(car.sensors.pack_voltage),
      dc_link_voltage_(car.sensors.dc_link_voltage),
      phase_current_(car.sensors.phase_current),
      motor_speed_(car.sensors.motor_speed),
      motor_temperature_(car.sensors.motor_temperature),
      inverter_temperature_(car.sensors.inverter_temperature),
      wheel_front_left_(car.sensors.wheel_front_left),
      wheel_front_right_(car.sensors.wheel_front_right),
      wheel_rear_left_(car.sensors.wheel_rear_left),
      wheel_rear_right_(car.sensors.wheel_rear_right),
      apps1_(car.sensors.apps1),
      apps2_(car.sensors.apps2),
      brake_front_(car.sensors.brake_front),
      brake_rear_(car.sensors.brake_rear),
      cells_(channels(car.sensors.all_cells, car.sensors.cells, indexed_count("sensors.cells", car))),
      thermistors_(channels(car.sensors.all_thermistors, car.sensors.thermistors,
                            indexed_count("sensors.thermistors", car))) {
  wheel_motor_speed_.fill(motor_speed_);
  wheel_current_.fill(phase_current_);
  const auto moves = [](const Instrument& instrument) { return instrument.moves(); };
  slow_moves_ = std::any_of(cells_.begin(), cells_.end(), moves) || motor_temperature_.moves() ||
                std::any_of(thermistors_.begin(), thermistors_.end(), moves) || inverter_temperature_.moves();
  VOLTLAP_DEMAND(rises(pedal_sensors.apps1) && rises(pedal_sensors.apps2));
}

void SensorFrames::send(Instant now, const Car& car, const Pedals& pedals, const Switches& switches, TxQueue& tx) {
  if (slow_moves_) follow_slow(car);
  send_pack(car, tx);
  send_pedals(pedals, tx);
  send_wheels(car, tx);
  const bool of_ours = !car.has_pm100() && !car.has_amk();
  if (car.has_pm100()) send_pm100_readings(now, car, tx);
  if (car.has_amk()) send_amk_readings(now, car, tx);
  if (of_ours) send_inverter(car, tx);
  send_io(car, switches, tx);
  send_cells(now, car, tx);
  send_temperatures(now, car, tx);
  if (of_ours) send_motor_temperatures(now, car, tx);
  if (car.charger.plugged) send_charger(now, car, tx);
}

void SensorFrames::follow_slow(const Car& car) {
  for (std::size_t i = 0; i < std::min(cells_.size(), car.pack().cells()); ++i) {
    cells_[i].follow(car.pack().read_voltage(i));
  }
  for (std::size_t i = 0; i < thermistors_.size(); ++i) thermistors_[i].follow(surface_at(car, i));
  motor_temperature_.follow(car.motor_thermal().copper_c());
  inverter_temperature_.follow(parameters_.environment.ambient_c);
}

double SensorFrames::surface_at(const Car& car, std::size_t thermistor) const {
  const auto count = static_cast<std::size_t>(parameters_.sensors.temperature_count);
  return car.pack().surface_temperature_c(std::min(thermistor, count - 1) * car.pack().cells() / count);
}

void SensorFrames::send_pack(const Car& car, TxQueue& tx) {
  can::PackSensor m;
  const double current_a = sensors_.current(pack_current_.scaled(pack_current_.follow(car.pack_current_a())));
  const double read_a = faults.current_gain * pack_current_.clipped(current_a) + faults.current_offset_a;
  if (!faults.current_frozen) last_current_ma_ = to_ma(read_a);
  m.pack_current_ma = last_current_ma_;
  m.pack_voltage_100uv = to_100uv(pack_voltage_.read(car.pack().voltage()));
  m.pack_current_ok = !faults.current_lost;
  m.pack_voltage_ok = true;
  codec::send(m, sealer_, tx);
}

void SensorFrames::send_pedals(const Pedals& pedals, TxQueue& tx) {
  can::Pedals m;
  m.apps1_100uv = to_100uv(apps1_.read(pedal_sensors_.apps1.voltage(pedals.accelerator)) + faults.apps1_offset_v);
  m.apps2_100uv = to_100uv(apps2_.read(pedal_sensors_.apps2.voltage(pedals.accelerator)));
  const double pressure_bar = pedals.brake * parameters_.brakes.full_pedal_pressure_bar;
  m.brake_front_mbar = to_units(brake_front_.read(pressure_bar), 1e3);
  m.brake_rear_mbar = to_units(brake_rear_.read(pressure_bar), 1e3);
  m.apps1_ok = m.apps2_ok = true;
  m.brake_front_ok = !faults.brake_lost[0];
  m.brake_rear_ok = !faults.brake_lost[1];
  codec::send(m, sealer_, tx);
}

void SensorFrames::send_wheels(const Car& car, TxQueue& tx) {
  can::WheelSpeeds m;
  const double radius = parameters_.tyres.radius_m;
  const double front_mps = std::abs(car.vehicle().front_omega()) * radius;
  const double rear_mps = std::abs(car.vehicle().rear_omega()) * radius;
  m.front_left_mmps = to_units(wheel_front_left_.read(front_mps), 1e3);
  m.front_right_mmps = to_units(wheel_front_right_.read(front_mps), 1e3);
  m.rear_left_mmps = to_units(wheel_rear_left_.read(rear_mps), 1e3);
  m.rear_right_mmps = to_units(wheel_rear_right_.read(rear_mps), 1e3);
  m.front_left_ok = m.front_right_ok = m.rear_left_ok = m.rear_right_ok = true;
  codec::send(m, sealer_, tx);
}

void SensorFrames::send_inverter(const Car& car, TxQueue& tx) {
  can::InverterStatus m;
  m.motor_speed_rpm = to_units(motor_speed_.read(car.motor_omega_rad_s() * kRpmPerRadPerS), 1.0);
  m.dc_link_voltage_100uv = to_100uv(faults.dc_link_v.value_or(dc_link_voltage_.read(car.dc_link_voltage())));
  m.phase_current_ma = to_ma(phase_current_.read(car.phase_current_a()));
  m.motor_speed_ok = m.dc_link_voltage_ok = m.phase_current_ok = true;
  switch (car.inverter.state(car.dc_link_voltage())) {
    case InverterState::kOff: m.state = can::InverterState::kOff; break;
    case InverterState::kDisabled: m.state = can::InverterState::kDisabled; break;
    case InverterState::kEnabled: m.state = can::InverterState::kEnabled; break;
    case InverterState::kCommandTimeout: m.state = can::InverterState::kCommandTimeout; break;
  }
  codec::send(m, sealer_, tx);
}

void SensorFrames::send_pm100_readings(Instant now, const Car& car, TxQueue& tx) {
  Pm100Readings r;
  r.motor_speed_rpm = motor_speed_.read(car.motor_omega_rad_s() * kRpmPerRadPerS);
  r.dc_link_v = faults.dc_link_v.value_or(dc_link_voltage_.read(car.dc_link_voltage()));
  r.phase_current_a = phase_current_.read(car.phase_current_a());
  r.dc_current_a = car.inverter_current_a();
  r.motor_c = shown(motor_temperature_, car.motor_thermal().copper_c());
  r.inverter_c = shown(inverter_temperature_, parameters_.environment.ambient_c);
  send_pm100(now, car, r, sealer_, tx);
}

// The same errors for all four: what is wrong with one alone is a fault of its frames. A winding that is read late is
// the hottest for all.
void SensorFrames::send_amk_readings(Instant now, const Car& car, TxQueue& tx) {
  AmkReadings r;
  for (std::size_t wheel = 0; wheel < codec::kWheels; ++wheel) {
    const MotorDrive& drive = car.drives[wheel];
    r.speed_rpm[wheel] = wheel_motor_speed_[wheel].read(car.motor_omega_rad_s(drive) * kRpmPerRadPerS);
    r.current_a[wheel] = wheel_current_[wheel].read(drive.current_a);
    r.motor_c[wheel] = shown(motor_temperature_, drive.thermal.copper_c());
  }
  r.inverter_c = shown(inverter_temperature_, parameters_.environment.ambient_c);
  r.dc_link_v = faults.dc_link_v.value_or(dc_link_voltage_.read(car.dc_link_voltage()));
  send_amk(now, car, r, sealer_, tx);
}

void SensorFrames::send_io(const Car& car, const Switches& switches, TxQueue& tx) {
  can::VehicleIo m;
  m.air_plus_aux = car.contactors.air_plus.closed();
  m.air_minus_aux = car.contactors.air_minus.closed();
  m.precharge_aux = car.contactors.precharge.closed();
  // Both devices sit in the shutdown circuit themselves.
  m.shutdown_closed = switches.shutdown_closed && !faults.interlock_open && !faults.isolation_fault;
  m.interlock_open = faults.interlock_open;
  m.isolation_fault = faults.isolation_fault;
  m.ts_on_button = switches.ts_on;
  m.rtd_button = switches.ready_to_drive;
  m.reset_button = switches.reset;
  m.charge_switch = switches.charge;
  codec::send(m, sealer_, tx);
}

void SensorFrames::send_cells(Instant now, const Car& car, TxQueue& tx) {
  const std::size_t cells = car.pack().cells();
  const std::int32_t cycle = can::cell_cycle_ms(cells);
  last_cell_100uv_.resize(cells);
  for (std::size_t group = 0; group * can::CellVoltages::kPerFrame < cells; ++group) {
    if (!can::due(now.ms(), cycle, static_cast<std::int32_t>(group * can::kTickMs))) continue;
    can::CellVoltages m;
    m.group = static_cast<std::uint8_t>(group);
    for (std::size_t i = 0; i < can::CellVoltages::kPerFrame; ++i) {
      const std::size_t cell = group * can::CellVoltages::kPerFrame + i;
      const SensorFaults::Channel fault = SensorFaults::of(faults.cells, cell);
      m.cell_ok[i] = cell < cells && !fault.lost;
      if (cell < cells) {
        const Instrument& instrument = cells_[std::min(cell, cells_.size() - 1)];
        const double arrived = instrument.arrived(car.pack().read_voltage(cell));
        const double read_v = instrument.clipped(sensors_.cell_voltage(instrument.scaled(arrived)));
        if (!fault.frozen) last_cell_100uv_[cell] = to_100uv(fault.gain * read_v + fault.offset);
        m.cell_100uv[i] = last_cell_100uv_[cell];
      }
    }
    codec::send(m, sealer_, tx);
  }
}

void SensorFrames::send_temperatures(Instant now, const Car& car, TxQueue& tx) {
  const auto count = static_cast<std::size_t>(parameters_.sensors.temperature_count);
  for (std::size_t group = 0; group * can::Temperatures::kPerFrame < count; ++group) {
    if (!row_due(can::Temperatures::kBaseId + static_cast<std::uint32_t>(group), now)) continue;
    can::Temperatures m;
    m.group = static_cast<std::uint8_t>(group);
    for (std::size_t i = 0; i < can::Temperatures::kPerFrame; ++i) {
      const std::size_t sensor = group * can::Temperatures::kPerFrame + i;
      const SensorFaults::Channel fault = SensorFaults::of(faults.thermistors, sensor);
      m.temperature_ok[i] = sensor < count && !fault.lost;
      if (sensor < count) {
        const Instrument& instrument = thermistors_[sensor];
        const double arrived = instrument.arrived(surface_at(car, sensor));
        m.temperature_dc[i] =
            to_dc(instrument.clipped(sensors_.temperature(instrument.scaled(arrived))) + fault.offset);
      }
    }
    codec::send(m, sealer_, tx);
  }
}

/// A charger is a node of its own, and says nothing where there is none.
void SensorFrames::send_charger(Instant now, const Car& car, TxQueue& tx) {
  if (faults.charger_silent || !row_due(can::ChargerStatus::kId, now)) return;
  can::ChargerStatus m;
  m.output_voltage_100uv = to_100uv(car.charger.link_v());
  m.output_current_ma = to_ma(car.charger.current_a());
  m.output_voltage_ok = m.output_current_ok = true;
  m.hardware_failure = car.charger.failed;
  m.battery_not_connected = !car.charger.connected();
  m.communication_timeout = car.charger.silent();
  codec::send(m, sealer_, tx);
}

void SensorFrames::send_motor_temperatures(Instant now, const Car& car, TxQueue& tx) {
  if (!row_due(can::MotorTemperatures::kId, now)) return;
  can::MotorTemperatures m;
  m.motor_dc = to_dc(shown(motor_temperature_, car.motor_thermal().copper_c()));
  // A heat sink at ambient: the inverter has no thermal model.
  m.inverter_dc = to_dc(shown(inverter_temperature_, parameters_.environment.ambient_c));
  m.motor_ok = m.inverter_ok = true;
  codec::send(m, sealer_, tx);
}

}  // namespace voltlap::plant
