// SPDX-License-Identifier: Apache-2.0
// Why the contactors are open: the first thing that is missing on the way to closed ones, as one code on the bus.
#pragma once
#include "bms/state.hpp"

namespace voltlap::bms {

[[nodiscard]] can::WaitsFor waits_for(const Config& config, const State& state);

/// The channel that is not believed and why; kNone when all are.
struct Suspect {
  std::uint8_t index = kNoCell;  ///< of a cell or a thermistor
  can::SuspectWhy why = can::SuspectWhy::kNone;
};
[[nodiscard]] Suspect find_suspect(const State& state);

}  // namespace voltlap::bms
