// SPDX-License-Identifier: Apache-2.0
// What four AMK inverters send: actual values 1 in every period, actual values 2 every 100 ms, each on the cycle that
// amk.dbc gives it; and the voltage of the DC link, which the car measures itself.
#pragma once
#include <array>

#include "base/can_frame.hpp"
#include "base/time.hpp"
#include "car/car.hpp"
#include "codec/amk_frames.hpp"
#include "codec/seal.hpp"

namespace voltlap::plant {

/// Through the instruments: those of all four are alike.
struct AmkReadings {
  std::array<double, codec::kWheels> speed_rpm{}, current_a{}, motor_c{};
  double inverter_c = 0.0, dc_link_v = 0.0;
};

void send_amk(Instant now, const Car& car, const AmkReadings& readings, codec::Sealer& sealer, TxQueue& tx);

}  // namespace voltlap::plant
