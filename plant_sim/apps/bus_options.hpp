// SPDX-License-Identifier: Apache-2.0
// The flags of everything that runs on a CAN interface.
#pragma once
#include <CLI/CLI.hpp>
#include <string>

namespace voltlap::plant {

struct BusOptions {
  std::string interface;
  bool realtime = false;
  double pace = 0.0;
  double lost_after_s = 5.0;

  CLI::Option* add_interface(CLI::App& command);
  CLI::Option* add_realtime(CLI::App& command);
  /// --pace and --lost-after, which make sense in lockstep only.
  void add_lockstep(CLI::App& command, CLI::Option* realtime);
};

}  // namespace voltlap::plant
