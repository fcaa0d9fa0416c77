// SPDX-License-Identifier: Apache-2.0
// A charge in words.
#pragma once
#include <string>

#include "charge/charge_run.hpp"

namespace voltlap::plant {

/// "12 h 03 min", "4 min 20 s".
[[nodiscard]] std::string duration_words(double seconds);
/// Why it ended, in a sentence without its full stop.
[[nodiscard]] std::string ending_words(const ChargeResult& result);
/// The table that the command prints; `what`: car and cells.
[[nodiscard]] std::string charge_text(const ChargeResult& result, const std::string& what);

[[nodiscard]] const char* phase_name(can::ChargePhase phase);
[[nodiscard]] const char* reason_name(can::ChargeReason reason);

}  // namespace voltlap::plant
