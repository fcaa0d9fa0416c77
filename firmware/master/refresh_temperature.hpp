// SPDX-License-Identifier: Apache-2.0
// MST-039: the ends of the message's range, -40 and 250 degC, are an open and a shorted sensor, no temperatures.
#pragma once
#include "base/units.hpp"
#include "codec/refresh.hpp"

namespace voltlap::master {

[[nodiscard]] constexpr bool inside_ends(std::int32_t value_dc) {
  constexpr std::int32_t kOpen_dc = -390, kShort_dc = 2'450;  // 1 and 5 K inside of it
  return kOpen_dc < value_dc && value_dc < kShort_dc;
}

inline void refresh_temperature(Sample<Temperature>& sample, bool ok, std::int32_t value_dc, Instant now) {
  codec::refresh(sample, ok && inside_ends(value_dc), Temperature::from_raw(value_dc), now);
}

/// The hottest of several; none where one of them is none, for that one may be it.
template <class... Others>
void refresh_hottest(Sample<Temperature>& sample, bool ok, Instant now, std::int32_t first_dc, Others... others_dc) {
  std::int32_t hottest = first_dc;
  ((hottest = others_dc > hottest ? others_dc : hottest), ...);
  refresh_temperature(sample, ok && (inside_ends(first_dc) && ... && inside_ends(others_dc)), hottest, now);
}

}  // namespace voltlap::master
