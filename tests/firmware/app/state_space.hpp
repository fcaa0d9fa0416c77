// SPDX-License-Identifier: Apache-2.0
// Every state that the machines of both nodes can reach together, by a breadth-first run of the real code: what the
// driver, the car and one fault at a time can do is tried from each, and every tick is held against the rules.
//
// Two situations count as one when their discrete states are equal and their ages fall into the same class: as fresh,
// longer than a reaction, longer than a start. From each class one representative goes on.
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "firmware/app/bench.hpp"

namespace voltlap::app::test {

/// What may be done to a car, one after the other. A fault ends with kNoFault only; one at a time.
enum class Deed : std::uint8_t {
  kWait, kWaitLong, kShutdown, kTsOn, kReadyButton, kReset, kBrake, kPedal,
  kNoFault, kCellHigh, kAirPlusWelded, kInverterFault, kBmsUnheard, kMasterUnheard, kPedalsUnheard, kCount
};
[[nodiscard]] const char* name_of(Deed deed);

struct StateSpace {
  struct Place {
    std::size_t from = 0;
    Deed by = Deed::kWait;
    bool drives = false;             ///< ready to drive
    std::vector<std::size_t> to;
  };
  std::vector<Place> places;
  std::size_t steps = 0;             ///< deeds that were tried
  std::size_t depth = 0;             ///< deeds in a row that lead to the last new place
  bool whole = false;                ///< nothing new is left
  std::string broken;                ///< the first rule that was broken, with the way there; empty: none

  /// Deeds from power-on to a place.
  [[nodiscard]] std::string way_to(std::size_t place) const;
  /// Places from which no way leads to a car that is ready to drive.
  [[nodiscard]] std::vector<std::size_t> dead_ends() const;
};

/// As far as `depth_max` deeds from power-on.
[[nodiscard]] StateSpace explore(std::size_t depth_max);

}  // namespace voltlap::app::test
