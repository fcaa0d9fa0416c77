// SPDX-License-Identifier: Apache-2.0
// Channels as people read them: names in words, numbers in three digits.
#pragma once
#include <string>

#include "explain/explanation.hpp"
#include "explain/say/numbers.hpp"

namespace voltlap::plant {

/// Three digits; what is only rounding of the reckoning is 0.
[[nodiscard]] std::string shown_number(double value);

/// "Cell voltage, given the current"
[[nodiscard]] std::string channel_title(const Explanation& explanation, const Trace& trace);

/// Does a cause change this channel?
[[nodiscard]] bool is_changed(const Trace& trace);

}  // namespace voltlap::plant
