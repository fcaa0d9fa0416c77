// SPDX-License-Identifier: Apache-2.0
// Where the firmware of a run is: the flags for it.
#pragma once
#include <CLI/CLI.hpp>
#include <string>

namespace voltlap::plant {

struct EcuOptions {
  std::string where = "inside";  ///< inside | qemu | process
  std::string image;             ///< empty: the one that the project builds
  bool count_instructions = false;

  /// --ecu, --image and --count-instructions.
  CLI::Option* add(CLI::App& command);
  [[nodiscard]] bool outside() const { return where != "inside"; }
};

}  // namespace voltlap::plant
