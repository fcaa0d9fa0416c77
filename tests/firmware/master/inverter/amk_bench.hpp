// SPDX-License-Identifier: Apache-2.0
// Four AMK inverters as a test makes them, and what a master controller makes of their frames.
#pragma once
#include "codec/amk_frames.hpp"
#include "codec/seal.hpp"
#include "codec/send.hpp"
#include "master/inverter/inverter.hpp"
#include "master/ingest.hpp"

namespace voltlap::master::bench {

inline Config amk_config() {
  Config config;
  config.inverter_protocol = InverterProtocol::kAmk;
  config.motor_constant_unm_per_a = 260'000;
  config.motor_speed_max = MotorSpeed::from_raw(20'000);
  config.motor_current_max = Current::from_raw(80'800);
  config.front_drive_share = Ratio::from_raw(300'000);
  config.front_brake_share = Ratio::from_raw(600'000);
  config.phase_current_max = Current::from_raw(230'000);
  config.inverter_excess_max = Current::from_raw(15'000);
  return config;
}

template <class Message>
Frame wheel_frame(const Message& m, std::size_t wheel) {
  Frame frame;
  codec::encode_amk(m, wheel, frame);
  return frame;
}

inline codec::AmkActual1 ready_amk() {
  codec::AmkActual1 m;
  m.system_ready = true;
  return m;
}
inline codec::AmkActual1 dc_on_amk() {
  codec::AmkActual1 m = ready_amk();
  m.dc_on = m.quit_dc_on = true;
  return m;
}
inline codec::AmkActual1 enabled_amk() {
  codec::AmkActual1 m = dc_on_amk();
  m.inverter_on = m.quit_inverter_on = true;
  return m;
}

/// Actual values in every period, to a receiver.
struct AmkBench {
  Config config = amk_config();
  Receiver receiver{};
  Instant now = Instant::from_ms(1'000);
  codec::AmkActual1 actual1[kWheels];
  codec::AmkActual2 actual2[kWheels];
  bool silent[kWheels] = {};

  AmkBench() {
    receiver.inverter = inverter_link(config);
    for (codec::AmkActual1& m : actual1) m = ready_amk();
  }
  void all(const codec::AmkActual1& m) {
    for (codec::AmkActual1& one : actual1) one = m;
  }
  void receive(const Frame& frame) { ingest(now, FrameView{&frame, 1}, receiver); }
  void run(int periods = 1) {
    for (int i = 0; i < periods; ++i) {
      now = now + Duration::from_ms(10);
      Frame frames[2 * kWheels];
      std::size_t count = 0;
      for (std::size_t k = 0; k < kWheels; ++k) {
        if (silent[k]) continue;
        frames[count++] = wheel_frame(actual1[k], k);
        frames[count++] = wheel_frame(actual2[k], k);
      }
      ingest(now, FrameView{frames, count}, receiver);
    }
  }
  [[nodiscard]] bool state_is(InverterState wanted) const {
    return receiver.input.inverter_state.good() && receiver.input.inverter_state.value == wanted;
  }
  [[nodiscard]] std::int32_t age_ms() const { return (now - receiver.input.inverter_state.time).ms(); }
};

}  // namespace voltlap::master::bench
