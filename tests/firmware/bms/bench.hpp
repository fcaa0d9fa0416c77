// SPDX-License-Identifier: Apache-2.0
// A pack on a bench: sends the frames of plant and master to the BMS tick by tick, every one of them adjustable.
#pragma once
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <set>
#include <vector>

#include "bms/bms_step.hpp"
#include "bms/transmit.hpp"
#include "can_dbc/car.hpp"
#include "can_dbc/charger.hpp"
#include "codec/seal.hpp"

#include "CppUTest/TestHarness.h"

namespace voltlap::bms::test {

inline Current amps(double a) { return Current::from_raw(static_cast<std::int32_t>(a * 1000 + (a < 0 ? -0.5 : 0.5))); }

/// 24 cells of 10 Ah and 2 mOhm; OCV from 3.0 V to 4.2 V in a straight line.
inline Config pack_config() {
  Config c;
  c.cells_in_series = 24;
  c.temperature_sensors = 6;
  c.capacity_mah = 10'000;
  c.ocv.count = 2;
  c.ocv.soc[1] = Soc::from_raw(1'000'000);
  c.ocv.voltage[0] = CellVoltage::from_raw(30'000);
  c.ocv.voltage[1] = CellVoltage::from_raw(42'000);
  c.resistance.count = 2;
  c.resistance.soc[1] = Soc::from_raw(1'000'000);
  c.resistance.resistance[0] = Resistance::from_raw(2'000);
  c.resistance.resistance[1] = Resistance::from_raw(2'000);
  c.discharge_current_max = amps(500);
  c.charge_current_max = amps(200);
  c.discharge_current_trip = amps(600);
  c.charge_current_trip = amps(300);
  return c;
}

class Bench {
 public:
  explicit Bench(const Config& c = pack_config()) : config(c) {
    for (auto& v : cell_100uv) v = 39'000;
    for (auto& t : temperature_dc) t = 250;
    master.drive_state = can::DriveState::kLvOn;
    io.shutdown_closed = true;
    pack.pack_current_ok = pack.pack_voltage_ok = true;
    inverter.dc_link_voltage_ok = inverter.motor_speed_ok = inverter.phase_current_ok = true;
  }

  Config config;
  State state{};
  std::uint32_t now_ms = 0;
  std::int32_t cell_100uv[kMaxCells] = {};
  std::int32_t temperature_dc[kMaxTemperatures] = {};
  std::set<std::size_t> invalid_cells, invalid_sensors;
  std::set<std::uint32_t> silent;                      ///< ids that are lost
  std::function<void(Frame&)> tamper = [](Frame&) {};  ///< applied to every sealed frame
  std::function<bool(Frame&)> again;                   ///< true: the frame, as it has left it, follows the true one
  can::PackSensor pack;
  can::InverterStatus inverter;
  can::VehicleIo io;
  can::MasterStatus master;
  can::ChargerStatus charger;
  bool charger_talks = false;      ///< there is one, and it reports every second
  bool sum_follows_cells = true;   ///< pack voltage is the sum of the cells
  bool aux_follow_command = true;  ///< contacts do what they are told
  bool link_follows = true;        ///< DC link charges in 100 ms and discharges in 1 s
  Output out{};

  Instant now() const { return Instant::from_ms(now_ms); }

  /// One step of 10 ms with every frame that is due.
  const Output& tick() {
    frames_.clear();
    if (sum_follows_cells) pack.pack_voltage_100uv = sum();
    send(pack);
    send(inverter);
    send(io);
    send(master);
    if (charger_talks && can::due(now_ms, can::ChargerStatus::kCycleMs, 90)) send(charger);
    send_groups();
    out = step(config, Input{now(), FrameView{frames_.data(), frames_.size()}}, state);
    if (aux_follow_command) follow_contactors();
    if (link_follows) follow_link();
    now_ms += 10;
    return out;
  }
  const Output& run(std::uint32_t ms) {
    for (std::uint32_t t = 0; t < ms; t += 10) tick();
    return out;
  }
  /// Milliseconds of steps until `done`, or -1 when it does not come within `most_ms`.
  std::int32_t until(const std::function<bool(const Output&)>& done, std::int32_t most_ms = 20'000) {
    for (std::int32_t t = 0; t <= most_ms; t += 10) {
      if (done(tick())) return t;
    }
    return -1;
  }

  /// The frames of the last step.
  [[nodiscard]] FrameView sent() const { return FrameView{frames_.data(), frames_.size()}; }

  void idle() { run(500); }
  void drive() {
    idle();
    request(true);
    until([](const Output& o) { return o.state == can::BmsState::kTsActive; });
    run(2000);  // the limits rise from zero
  }
  void request(bool ts) { master.ts_request = ts; }
  void cells(std::int32_t v_100uv) {
    for (auto& v : cell_100uv) v = v_100uv;
  }
  void current(Current i) { pack.pack_current_ma = i.raw(); }

 private:
  template <class M>
  void send(const M& m) {
    Frame frame;
    can::encode(m, frame);
    sealer_.seal(frame);
    if (silent.count(frame.id) != 0) return;
    tamper(frame);
    frames_.push_back(frame);
    if (again && again(frame)) frames_.push_back(frame);
  }
  void send_groups() {
    const std::int32_t cycle = can::cell_cycle_ms(config.cells_in_series);
    for (std::size_t g = 0; g * 3 < config.cells_in_series && g < can::CellVoltages::kGroups; ++g) {
      if (!can::due(now_ms, cycle, static_cast<std::int32_t>(10 * g))) continue;
      can::CellVoltages m;
      m.group = static_cast<std::uint8_t>(g);
      for (std::size_t i = 0; i < 3; ++i) {
        m.cell_100uv[i] = cell_100uv[3 * g + i];
        m.cell_ok[i] = 3 * g + i < config.cells_in_series && invalid_cells.count(3 * g + i) == 0;
      }
      send(m);
    }
    for (std::size_t g = 0; g < can::Temperatures::kGroups; ++g) {
      if (!can::due(now_ms, can::Temperatures::kCycleMs, static_cast<std::int32_t>(10 * g))) continue;
      can::Temperatures m;
      m.group = static_cast<std::uint8_t>(g);
      for (std::size_t i = 0; i < 3; ++i) {
        m.temperature_dc[i] = temperature_dc[3 * g + i];
        m.temperature_ok[i] = 3 * g + i < config.temperature_sensors && invalid_sensors.count(3 * g + i) == 0;
      }
      send(m);
    }
  }
  std::int32_t sum() const {
    std::int32_t total = 0;
    for (std::size_t i = 0; i < config.cells_in_series; ++i) total += cell_100uv[i];
    return total;
  }
  void follow_contactors() {
    io.air_plus_aux = out.contactors.air_plus;
    io.air_minus_aux = out.contactors.air_minus;
    io.precharge_aux = out.contactors.precharge;
  }
  void follow_link() {
    const bool connected = out.contactors.air_minus && (out.contactors.precharge || out.contactors.air_plus);
    const std::int32_t step_up = sum() / 10;
    std::int32_t& link = inverter.dc_link_voltage_100uv;
    link = connected ? std::min(sum(), link + step_up) : std::max(0, link - step_up / 10);
  }

  codec::Sealer sealer_;
  std::vector<Frame> frames_;
};

inline bool has(const Output& out, can::BmsFault fault) {
  return (out.faults >> static_cast<unsigned>(fault) & 1) != 0;
}
inline bool all_open(const Output& out) {
  return !out.contactors.air_plus && !out.contactors.air_minus && !out.contactors.precharge;
}

/// States the time that a requirement took, and fails outside of its bound.
inline void expect_time(const char* requirement, std::int32_t took_ms, std::int32_t low_ms, std::int32_t high_ms) {
  std::printf("%s: %d ms (bound %d to %d ms)\n", requirement, took_ms, low_ms, high_ms);
  CHECK_TEXT(took_ms >= low_ms && took_ms <= high_ms, requirement);
}

}  // namespace voltlap::bms::test
