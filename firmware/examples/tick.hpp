// SPDX-License-Identifier: Apache-2.0
// What the loops of the examples have in common.
#pragma once
#include "base/can_frame.hpp"
#include "base/time.hpp"
#include "can_dbc/tables.hpp"

namespace voltlap::examples {

inline constexpr Duration kTick = Duration::from_ms(static_cast<std::int32_t>(can::kTickMs));
/// At the latest, by the slowest oscillator of a watchdog: before the 70 ms are over after which the car opens its
/// contactors without a command. The fastest of an STM32F4 bites after 21 ms, two ticks.
inline constexpr Duration kWatchdogTime = Duration::from_ms(60);
/// What 500 kbit/s carry in a tick is less than half of it; more is lost, and the counters of the frames say so.
inline constexpr std::size_t kInbox = 2 * TxQueue::kCapacity;

}  // namespace voltlap::examples
