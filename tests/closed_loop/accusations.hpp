// SPDX-License-Identifier: Apache-2.0
// What the BMS says when it does not believe a channel or a contactor.
#pragma once
#include <cstdint>

#include "can_dbc/car.hpp"

namespace voltlap::plant::test {

constexpr std::uint32_t bit(can::BmsFault fault) { return 1U << static_cast<unsigned>(fault); }

inline constexpr std::uint32_t kAccuses =
    bit(can::BmsFault::kCellImplausible) | bit(can::BmsFault::kCurrentImplausible) |
    bit(can::BmsFault::kTemperatureImplausible) | bit(can::BmsFault::kVoltageImplausible) |
    bit(can::BmsFault::kContactorWelded) | bit(can::BmsFault::kContactorStuckOpen) |
    bit(can::BmsFault::kPrechargeTimeout) | bit(can::BmsFault::kCellMeasurementLost) |
    bit(can::BmsFault::kConfigInvalid) | bit(can::BmsFault::kTemperatureMeasurementLost);

/// The last channel that was suspected, as the bus tells it.
struct Suspicion {
  void hear(const Frame& frame) {
    can::ContactorCommand command;
    if (!can::decode(frame, command) || command.suspect_why == can::SuspectWhy::kNone) return;
    index = command.suspect;
    why = command.suspect_why;
  }
  int index = 255;
  can::SuspectWhy why = can::SuspectWhy::kNone;
};

}  // namespace voltlap::plant::test
