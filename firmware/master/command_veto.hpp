// SPDX-License-Identifier: Apache-2.0
// The last word before the bus: knows freshness and limits, nothing of how the command came about, and may only veto.
#pragma once
#include "master/config.hpp"
#include "master/inverter_command.hpp"
#include "master/io.hpp"

namespace voltlap::master {

/// Whether `command` may be sent as it is. False: send zero current, disabled.
[[nodiscard]] bool command_allowed(const Config& config, const Input& input, const InverterCommand& command);

}  // namespace voltlap::master
