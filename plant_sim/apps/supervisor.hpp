// SPDX-License-Identifier: Apache-2.0
// Plant, BMS, master controller and logger as processes of one run: started together, watched, ended together.
#pragma once
#include <CLI/CLI.hpp>
#include <string>

#include "apps/bus_options.hpp"

namespace voltlap::plant {

/// Runs what `command` asks for on an interface and returns the exit code. Every flag given to the command goes to
/// the plant, the car's flags also to the control units; `candump` not empty adds a logger.
int supervise(const CLI::App& command, const BusOptions& bus, const std::string& candump);

}  // namespace voltlap::plant
