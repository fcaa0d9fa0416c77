// SPDX-License-Identifier: Apache-2.0
// Both nodes in a loop with a hand-made car: frames of the car, then BMS, then master, every 10 ms.
#pragma once
#include <algorithm>
#include <functional>
#include <set>
#include <vector>

#include "app/bms_node.hpp"
#include "app/master_node.hpp"
#include "firmware/bms/bench.hpp"

namespace voltlap::app::test {

inline constexpr std::int32_t kTickMs = 10;

class Loop {
 public:
  BmsNode bms;
  MasterNode master;

  // The car, adjustable.
  can::PackSensor pack;
  can::Pedals pedals;
  can::WheelSpeeds wheels;
  can::InverterStatus inverter;
  can::VehicleIo io;
  can::MotorTemperatures temperatures;
  std::int32_t cell_100uv = 39'000;
  bool inverter_follows = true;  ///< state and current do what the command asks
  bool air_plus_welded = false;

  // Faults of the bus.
  std::set<std::uint32_t> silent;                            ///< identifiers that are not delivered
  bool bms_dead = false;                                     ///< the BMS no longer runs
  std::function<void(Frame&)> tamper = [](Frame&) {};        ///< every delivered frame passes here
  /// Puts a frame on the bus; may keep it, or put others there too.
  std::function<void(const Frame&, std::vector<Frame>&)> bus = [](const Frame& frame, std::vector<Frame>& frames) {
    frames.push_back(frame);
  };

  // What the car has received last.
  can::ContactorCommand contactors;
  can::InverterCommand command;
  can::BmsStatus bms_status;
  can::BmsLimits bms_limits;
  can::MasterStatus master_status;
  std::uint32_t now_ms = 0;
  std::size_t frames_in_tick = 0;

  explicit Loop(const bms::Config& bms_config = bms::test::pack_config(), const master::Config& master_config = {})
      : bms(bms_config), master(master_config) {
    pack.pack_current_ok = pack.pack_voltage_ok = true;
    pedals.apps1_ok = pedals.apps2_ok = pedals.brake_front_ok = pedals.brake_rear_ok = true;
    wheels.front_left_ok = wheels.front_right_ok = wheels.rear_left_ok = wheels.rear_right_ok = true;
    inverter.motor_speed_ok = inverter.dc_link_voltage_ok = inverter.phase_current_ok = true;
    inverter.state = can::InverterState::kDisabled;
    temperatures.motor_ok = temperatures.inverter_ok = true;
    temperatures.motor_dc = temperatures.inverter_dc = 300;
    io.shutdown_closed = true;
    pedal(0);
  }

  void pedal(std::int32_t per_mille) {
    pedals.apps1_100uv = 5'000 + 40 * per_mille;
    pedals.apps2_100uv = 2'500 + 20 * per_mille;
  }
  void brake(std::int32_t mbar) { pedals.brake_front_mbar = pedals.brake_rear_mbar = mbar; }

  void tick() {
    frames_.clear();
    send_car();
    deliver(last_master_);
    const std::vector<Frame> from_bms =
        run_node([this](Instant t, FrameView rx, TxQueue& tx) { bms.tick(t, rx, tx); }, !bms_dead);
    deliver(from_bms);
    last_master_ = run_node([this](Instant t, FrameView rx, TxQueue& tx) { master.tick(t, rx, tx); }, true);
    frames_in_tick = car_frames_ + from_bms.size() + last_master_.size();
    for (const Frame& frame : from_bms) read(frame);
    for (const Frame& frame : last_master_) read(frame);
    move_car();
    now_ms += kTickMs;
  }
  void run(std::int32_t ms) {
    for (std::int32_t t = 0; t < ms; t += kTickMs) tick();
  }
  /// Milliseconds until `done` after a tick, -1 when it does not come within `most_ms`. The first tick counts 0.
  std::int32_t until(const std::function<bool()>& done, std::int32_t most_ms = 20'000) {
    for (std::int32_t t = 0; t <= most_ms; t += kTickMs) {
      tick();
      if (done()) return t;
    }
    return -1;
  }
  bool in(can::DriveState state) const { return master_status.drive_state == state; }

  void start_to_ts_active() {
    run(1'000);
    io.ts_on_button = true;
    run(100);
    io.ts_on_button = false;
    until([this] { return in(can::DriveState::kTsActive); });
  }
  void start_to_ready() {
    start_to_ts_active();
    run(2'000);
    brake(20'000);
    io.rtd_button = true;
    run(100);
    io.rtd_button = false;
    brake(0);
    run(100);
  }
  void start_to_full_pedal() {
    start_to_ready();
    pedal(1000);
    run(200);
  }

 private:
  void put(Frame frame) {
    if (silent.count(frame.id) != 0) return;
    tamper(frame);
    bus(frame, frames_);
  }
  template <class Message>
  void send(const Message& message) {
    Frame frame;
    encode(message, frame);
    sealer_.seal(frame);
    ++car_frames_;
    put(frame);
  }
  void send_car() {
    car_frames_ = 0;
    pack.pack_voltage_100uv = 24 * cell_100uv;
    send(pack);
    send(pedals);
    send(wheels);
    send(inverter);
    send(io);
    if (can::due(now_ms, can::MotorTemperatures::kCycleMs, 50)) send(temperatures);
    for (std::uint8_t group = 0; group < 8; ++group) {
      if (can::due(now_ms, 30, 10 * group)) send(cells(group));
    }
    for (std::uint8_t group = 0; group < 2; ++group) {
      if (can::due(now_ms, can::Temperatures::kCycleMs, 10 * group)) send(sensors(group));
    }
  }
  can::CellVoltages cells(std::uint8_t group) const {
    can::CellVoltages m;
    m.group = group;
    for (int i = 0; i < 3; ++i) {
      m.cell_100uv[i] = cell_100uv;
      m.cell_ok[i] = true;
    }
    return m;
  }
  static can::Temperatures sensors(std::uint8_t group) {
    can::Temperatures m;
    m.group = group;
    for (int i = 0; i < 3; ++i) {
      m.temperature_dc[i] = 250;
      m.temperature_ok[i] = true;
    }
    return m;
  }
  void deliver(const std::vector<Frame>& frames) {
    for (const Frame& frame : frames) put(frame);
  }
  template <class Tick>
  std::vector<Frame> run_node(Tick node, bool alive) {
    TxQueue tx;
    if (alive) node(Instant::from_ms(now_ms), FrameView{frames_.data(), frames_.size()}, tx);
    return {tx.begin(), tx.end()};
  }
  void read(const Frame& frame) {
    (void)(decode(frame, contactors) || decode(frame, command) || decode(frame, bms_status) ||
           decode(frame, bms_limits) || decode(frame, master_status));
  }
  // Contacts follow at once, the DC link charges in 100 ms, the inverter does what it is told.
  void move_car() {
    io.air_plus_aux = contactors.air_plus_close || air_plus_welded;
    io.air_minus_aux = contactors.air_minus_close;
    io.precharge_aux = contactors.precharge_close;
    const bool connected = contactors.air_minus_close && (contactors.precharge_close || io.air_plus_aux);
    std::int32_t& link = inverter.dc_link_voltage_100uv;
    const std::int32_t full = 24 * cell_100uv;
    link = connected ? std::min(full, link + full / 10) : std::max(0, link - full / 100);
    if (!inverter_follows) return;
    inverter.state = command.enable ? can::InverterState::kEnabled : can::InverterState::kDisabled;
    inverter.phase_current_ma = command.enable ? command.phase_current_ma : 0;
    // I_dc = K omega I_phase / V, no losses
    const std::int64_t induced_100uv = std::int64_t{150'000} * inverter.motor_speed_rpm * 104'720 / 100'000'000;
    pack.pack_current_ma = static_cast<std::int32_t>(induced_100uv * inverter.phase_current_ma / full);
  }

  codec::Sealer sealer_;
  std::vector<Frame> frames_;
  std::vector<Frame> last_master_;
  std::size_t car_frames_ = 0;
};

/// States the time that a requirement took, and fails outside of its bound.
using bms::test::expect_time;

}  // namespace voltlap::app::test
