// SPDX-License-Identifier: Apache-2.0
// The virtual test bench: cells of the plant's own model in a box, a load, instruments, and an operator who keeps
// to the plan by what the instruments say.
#pragma once
#include <cstdint>
#include <functional>
#include <vector>

#include "learn/bench/bench_record.hpp"
#include "learn/bench/instruments.hpp"

namespace voltlap::plant {

/// Asked about once a simulated minute; true stops the test.
using StopRequest = std::function<bool(double time_s)>;

/// The cells of one test.
struct BenchCells {
  CellParameters cell;
  std::vector<CellVariation> variations;  ///< one a cell
  bool equal = false;                     ///< one cell is integrated and stands for all
};

/// Runs one test. `errors` belong to the instruments, `noise_seed` to the test. Throws InputError for a cell that
/// the plant refuses, and when no pulse ever reaches the stop rule.
[[nodiscard]] BenchRecord run_bench_test(const BenchPlan& plan, const BenchTest& test, const BenchCells& cells,
                                        const InstrumentErrors& errors, std::uint64_t noise_seed,
                                        const StopRequest& stop = {});

}  // namespace voltlap::plant
