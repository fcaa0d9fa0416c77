// SPDX-License-Identifier: Apache-2.0
// A circuit of 3 or 4 RC branches as the one of two that follows its voltage best after a step of the current, and how
// far off that is. For filters that keep two branches.
//
//   s(t) = R0 + sum over k of R_k (1 - exp(-t / tau_k))                     [ohm], volts a step of 1 A takes after t
//   least over R0' >= R0, R_a, R_b >= 0 and tau_a < tau_b:  sum of (s'(t) - s(t))^2,  t = 1 s .. 600 s, evenly in ln t
//
// What is over within the first second counts as R0. Time constants stay between the shortest and the longest of the
// cell. One or two branches come back as they are; the second of one is none, 0 ohm.
#pragma once
#include <vector>

#include "car/battery/cell_tables.hpp"
#include "core/parameters.hpp"

namespace voltlap::plant {

/// Of `branches` branches, at one point of the tables.
[[nodiscard]] CircuitOf<2> two_branches(const CircuitParameters& circuit, std::size_t branches);

/// How far a reduced circuit's voltage is from the whole one's over the step, per ampere.
struct StepError {
  double largest_ohm = 0.0, rms_ohm = 0.0;  ///< over 1 s .. 600 s, evenly in ln t
};
[[nodiscard]] StepError step_error(const CircuitParameters& circuit, const CircuitOf<2>& reduced);

/// A cell at the reference temperature and current of its file, at each SOC.
struct BranchReduction {
  std::size_t branches = 0;  ///< that the cell has
  std::vector<CircuitOf<2>> circuits;
  double largest_v = 0.0, largest_at_soc = 0.0, rms_v = 0.0;  ///< of a step of 1C, over all SOC
};
[[nodiscard]] BranchReduction reduce_branches(const CellParameters& cell, const std::vector<double>& soc);

}  // namespace voltlap::plant
