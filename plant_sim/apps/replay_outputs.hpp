// SPDX-License-Identifier: Apache-2.0
// What a replay leaves: --json, --csv, --report, and the summary on the terminal.
#pragma once
#include <CLI/CLI.hpp>
#include <cstdio>
#include <string>

#include "replay/replay_result.hpp"

namespace voltlap::plant {

struct ReplayOutputs {
  std::string json, csv, report;

  void add(CLI::App& command);
  /// The files that were asked for.
  void write(const ReplayResult& result) const;
  /// Where what people read goes.
  [[nodiscard]] std::FILE* stream() const;
};

}  // namespace voltlap::plant
