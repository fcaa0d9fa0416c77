// SPDX-License-Identifier: Apache-2.0
// `voltlap log`: what its commands have in common. Recording belongs to driving and is done by `voltlap`; what reads
// recordings is `voltlap-logs` beside it.
#pragma once
#include <CLI/CLI.hpp>


namespace voltlap::plant {

inline constexpr const char* kLogRecord = "Write the frames on a CAN interface as a candump log";

/// The command `log` of a program, made when it is first asked for.
[[nodiscard]] CLI::App& log_group(CLI::App& app);

}  // namespace voltlap::plant
