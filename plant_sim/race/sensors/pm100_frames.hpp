// SPDX-License-Identifier: Apache-2.0
// What a PM100 sends: fast frames in every period, slow ones every 100 ms, each on the cycle that pm100.dbc gives it.
#pragma once
#include "base/can_frame.hpp"
#include "base/time.hpp"
#include "car/car.hpp"
#include "codec/seal.hpp"

namespace voltlap::plant {

/// Through the instruments.
struct Pm100Readings {
  double motor_speed_rpm = 0.0, dc_link_v = 0.0, phase_current_a = 0.0, dc_current_a = 0.0;
  double motor_c = 0.0, inverter_c = 0.0;
};

void send_pm100(Instant now, const Car& car, const Pm100Readings& readings, codec::Sealer& sealer, TxQueue& tx);

}  // namespace voltlap::plant
