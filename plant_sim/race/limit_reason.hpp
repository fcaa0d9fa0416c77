// SPDX-License-Identifier: Apache-2.0
// Why the driver got less than asked for; the first are the BMS's reasons, by their numbers in car.dbc.
#pragma once
#include <cstddef>

#include "race/actuators/command_receiver.hpp"

namespace voltlap::plant {

inline constexpr std::size_t kLimitReasons = 15;
[[nodiscard]] const char* limit_reason_name(std::size_t reason);

/// The reason that binds now, as the ECUs last said; 0 when none does.
[[nodiscard]] std::size_t binding_limit_reason(const CommandReceiver& ecus);

}  // namespace voltlap::plant
