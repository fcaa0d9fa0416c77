// SPDX-License-Identifier: Apache-2.0
// All tests of a plan on one set of cells and instruments, and the same in rehearsal: one nominal cell, ideal
// instruments, a coarser step. The rehearsal is what is printed before a run.
#pragma once
#include <cstdint>
#include <vector>

#include "learn/bench/virtual_bench.hpp"

namespace voltlap::plant {

class Campaign {
 public:
  /// `cell`: the truth. The seed draws cells, instruments and noise.
  Campaign(BenchPlan plan, CellParameters cell, std::uint64_t seed);

  [[nodiscard]] const std::vector<BenchTest>& tests() const { return tests_; }
  [[nodiscard]] const BenchPlan& plan() const { return plan_; }
  [[nodiscard]] const CellParameters& cell() const { return cell_; }
  [[nodiscard]] const InstrumentErrors& errors() const { return errors_; }
  [[nodiscard]] std::uint64_t seed() const { return seed_; }

  /// Test `index` of tests(), as the bench does it.
  [[nodiscard]] BenchRecord run(std::size_t index, const StopRequest& stop = {}) const;
  /// The same test, rehearsed.
  [[nodiscard]] BenchRecord rehearse(std::size_t index, const StopRequest& stop = {}) const;

 private:
  [[nodiscard]] std::vector<CellVariation> cells_of(std::size_t index) const;

  BenchPlan plan_, rehearsal_;
  CellParameters cell_;
  std::uint64_t seed_;
  std::vector<BenchTest> tests_;
  std::vector<CellVariation> cells_;  ///< without the initial SOC, which is new in every test
  InstrumentErrors errors_;
};

}  // namespace voltlap::plant
