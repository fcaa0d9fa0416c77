// SPDX-License-Identifier: Apache-2.0
// A measurement is a value, the time it was taken and how good it is. All-zero memory is "never received".
#pragma once
#include "base/time.hpp"

namespace voltlap {

enum class Quality : std::uint8_t {
  kNone = 0,     ///< never received
  kGood = 1,     ///< fresh, complete, inside its range
  kInvalid = 2,  ///< the sender marked it invalid, or it is outside its range
  kStale = 3,    ///< older than its timeout
};

template <class T>
struct Sample {
  T value{};
  Instant time{};
  Quality quality = Quality::kNone;

  [[nodiscard]] constexpr bool good() const { return quality == Quality::kGood; }
};

}  // namespace voltlap
