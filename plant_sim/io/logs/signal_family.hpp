// SPDX-License-Identifier: Apache-2.0
// Cells and thermistors among the signals of a recording: names that differ in a number alone, or in the number or
// letter of a module and another one within it.
#pragma once
#include <vector>

#include "io/logs/signal_candidate.hpp"

namespace voltlap::plant {

enum class FamilyKind { kCells, kThermistors };

struct SignalFamily {
  std::vector<SignalCandidate> members;  ///< in order; of modules their numbers go on from module to module
  bool of_modules = false;
};

/// The largest family of a kind, plain names before others; no members where there is none. Most of its members are in
/// range: one that is not is a cell or a sensor that is broken, and belongs to it all the same.
[[nodiscard]] SignalFamily largest_family(const std::vector<SignalCandidate>& candidates, FamilyKind kind);

}  // namespace voltlap::plant
