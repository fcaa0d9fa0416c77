// SPDX-License-Identifier: Apache-2.0
// A signal that could be the battery's current or voltage: what its name is worth, and its course.
#pragma once
#include <cstddef>
#include <vector>

#include "io/logs/signal_candidate.hpp"
#include "io/logs/voltage_answer.hpp"

namespace voltlap::plant {

/// How much a name says: the role and nothing else, the role among other words, its unit alone, nothing at all.
enum class Standing { kExcluded = -2, kNotActual = -1, kUnnamed = 0, kByUnit = 1, kWorded = 2, kPlain = 3 };

struct Contender {
  const SignalCandidate* candidate;
  Standing standing;
  std::vector<double> means;
  const Contender* voltage = nullptr;  ///< of a current: that which answers to it most clearly
  VoltageAnswer answer;                ///< of that voltage
};

[[nodiscard]] Standing standing_of(const SignalCandidate& candidate, Quantity quantity, Meaning meaning,
                                   bool is_can);

/// A battery's voltage is never far from where it was; a power, a torque or a speed is.
[[nodiscard]] bool is_like_a_voltage(const SignalCandidate& candidate);

/// One signal twice, perhaps rounded: either is right.
[[nodiscard]] bool is_same(const Contender& a, const Contender& b);

/// Two sensors of one voltage, but for their errors.
[[nodiscard]] bool is_same_level(const Contender& a, const Contender& b);

/// Cells of one series that are called alike but for their number: any of them answers to the current.
[[nodiscard]] bool are_cells_alike(const Contender& a, const Contender& b);

struct LineFit {
  double rest;  ///< share of the variance that a straight line leaves
  std::size_t count;
};
/// y against x, or against x z.
[[nodiscard]] LineFit line_fit(const std::vector<double>& y, const std::vector<double>& x,
                               const std::vector<double>* z);

}  // namespace voltlap::plant
