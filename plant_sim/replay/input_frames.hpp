// SPDX-License-Identifier: Apache-2.0
// Readings of a recording as the sealed frames that the control units expect, each on the cycle of its message.
#pragma once
#include <cstddef>
#include <functional>

#include "base/can_frame.hpp"
#include "base/time.hpp"
#include "codec/seal.hpp"
#include "race/sensors/pedal_sensors.hpp"
#include "race/sensors/sensor_frames.hpp"
#include "replay/replay_result.hpp"

namespace voltlap::plant {

/// What the nodes are told; NaN: the frame says that there is no value.
struct Readings {
  double current_a = kUnknown, pack_v = kUnknown, dc_link_v = 0.0;
  double motor_speed_rpm = 0.0, phase_current_a = 0.0;
  double accelerator = 0.0, brake_bar = 0.0;
  double wheel_mps[4] = {};
  bool air_plus = false, air_minus = false, precharge = false;
  Switches switches{};
};

class InputFrames {
 public:
  using Value = std::function<double(std::size_t)>;
  /// `cell`, `thermistor`: the value of one from 0 now, asked for when its frame is due.
  InputFrames(std::size_t cells, std::size_t thermistors, const PedalSensors& pedals, Value cell, Value thermistor);

  void send(Instant now, const Readings& readings, TxQueue& tx);

 private:
  void send_cells(Instant now, TxQueue& tx);
  void send_temperatures(Instant now, TxQueue& tx);
  void send_motor_temperatures(Instant now, TxQueue& tx);
  void send_pack(const Readings& r, TxQueue& tx);
  void send_pedals(const Readings& r, TxQueue& tx);
  void send_wheels(const Readings& r, TxQueue& tx);
  void send_inverter(const Readings& r, TxQueue& tx);
  void send_io(const Readings& r, TxQueue& tx);

  std::size_t cells_, thermistors_;
  PedalSensors pedals_;
  Value cell_, thermistor_;
  codec::Sealer sealer_{};
};

}  // namespace voltlap::plant
