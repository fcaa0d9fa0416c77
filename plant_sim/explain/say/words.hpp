// SPDX-License-Identifier: Apache-2.0
// An answer in words and in numbers that a reader understands. No number stands in a sentence that the log does not
// hold.
#pragma once
#include <string>
#include <vector>

#include "explain/decide/answer.hpp"
#include "explain/explanation.hpp"

namespace voltlap::explain {

/// Name of a member's cause with where it is: "weak_cell", "voltage_offset (pack_voltage)".
[[nodiscard]] std::vector<std::string> names_of(const AnswerOf& answer, const Set& set);

/// Each cause of a set with its sizes, intervals and sentence; share and probability are the caller's.
[[nodiscard]] std::vector<plant::FoundCause> found_causes(const AnswerOf& answer, const Set& set,
                                                          const std::vector<plant::Cause>& causes);

/// "a", "a and b", "a, b and c".
[[nodiscard]] std::string listed(const std::vector<std::string>& parts, const char* last);

}  // namespace voltlap::explain
