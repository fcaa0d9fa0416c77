// SPDX-License-Identifier: Apache-2.0
// A thermistor against itself and its neighbours: no cell changes its temperature by 8 K within seconds, and no cell of
// a pack is 25 K away from the mean of the others. Its open and its short end are no readings (ingest).
#pragma once
#include <cstdint>

#include "base/time.hpp"
#include "base/units.hpp"
#include "bms/config.hpp"

namespace voltlap::bms {

struct State;

struct TemperatureTrack {
  Instant time{};
  std::int32_t slow = 0;  ///< [0.1 degC / 256] mean over 5 s
  bool begun = false;
};

/// Written by temperature_check.
struct TemperatureCheck {
  TemperatureTrack sensor[kMaxTemperatures] = {};
  std::uint8_t too_fast = kNoCell;  ///< a sensor that is, or kNoCell
  std::uint8_t apart = kNoCell;
};

void check_temperatures(const Config& config, Instant now, State& state);

}  // namespace voltlap::bms
