// SPDX-License-Identifier: Apache-2.0
// What is measured. Each run of a workload does exactly the same work from the same state.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "stopwatch.hpp"

namespace voltlap::benchmarks {

/// How much a run did: the number of operations that one row counts, and what they simulated.
struct Amount {
  double operations;
  double simulated_s;
};

struct Workload {
  std::string name;
  std::string operation;  ///< what one operation is, in words
  int repetitions;        ///< of a whole measurement
  std::function<Amount(Stopwatch&)> run;
};

[[nodiscard]] std::vector<Workload> workloads();

}  // namespace voltlap::benchmarks
