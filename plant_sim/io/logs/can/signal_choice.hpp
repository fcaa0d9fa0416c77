// SPDX-License-Identifier: Apache-2.0
// Which signals of a recording are meant: all, or those whose names fit one of some patterns.
#pragma once
#include <string>
#include <vector>

#include "io/logs/dbc_file.hpp"

namespace voltlap::plant {

class SignalChoice {
 public:
  /// Patterns as a shell has them (*, ?), for the signal's name or for "Frame.Signal"; none: every signal.
  explicit SignalChoice(std::vector<std::string> patterns) : patterns_(std::move(patterns)) {}

  [[nodiscard]] bool has(const DbcMessage& message, const DbcSignal& signal) const;
  /// Patterns that fit no signal of these messages.
  [[nodiscard]] std::vector<std::string> without_match(const std::vector<const DbcMessage*>& messages) const;

 private:
  std::vector<std::string> patterns_;
};

}  // namespace voltlap::plant
