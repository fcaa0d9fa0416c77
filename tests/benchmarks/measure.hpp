// SPDX-License-Identifier: Apache-2.0
// Runs the workloads, repetitions of all of them mixed, and estimates.
#pragma once
#include <string>

#include "result_file.hpp"

namespace voltlap::benchmarks {

struct Plan {
  std::string filter;  ///< regular expression on the names; empty: all
  bool quick = false;  ///< a third of the repetitions, at least four
};

/// Shows progress on standard error. Throws InputError when the filter matches nothing or is no regular expression.
[[nodiscard]] Measurement measure(const Plan& plan);

}  // namespace voltlap::benchmarks
