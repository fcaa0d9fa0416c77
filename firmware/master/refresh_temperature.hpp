// SPDX-License-Identifier: Apache-2.0
// MST-039: the ends of the message's range, -40 and 250 degC, are an open and a shorted sensor, no temperatures.
#pragma once
#include "base/units.hpp"
#include "codec/refresh.hpp"

namespace voltlap::master {

inline void refresh_temperature(Sample<Temperature>& sample, bool ok, std::int32_t value_dc, Instant now) {
  constexpr std::int32_t kOpen_dc = -390, kShort_dc = 2'450;  // 1 and 5 K inside of it
  codec::refresh(sample, ok && kOpen_dc < value_dc && value_dc < kShort_dc, Temperature::from_raw(value_dc), now);
}

}  // namespace voltlap::master
