// SPDX-License-Identifier: Apache-2.0
// Conditions on a configuration as a table: what must hold, and the name of it when it does not.
#pragma once
#include <cstddef>

namespace voltlap {

template <class Error>
struct Condition {
  bool holds;
  Error otherwise;
};

/// The first that does not hold; Error{} when all do.
template <class Error, std::size_t N>
[[nodiscard]] constexpr Error first_broken(const Condition<Error> (&conditions)[N]) {
  for (const Condition<Error>& condition : conditions) {
    if (!condition.holds) return condition.otherwise;
  }
  return Error{};
}

}  // namespace voltlap
