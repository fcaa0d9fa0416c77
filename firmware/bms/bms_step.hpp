// SPDX-License-Identifier: Apache-2.0
// The BMS: one step every 10 ms. Time and frames come in, decisions go out; transmit.hpp makes frames of them.
#pragma once
#include "bms/state.hpp"

namespace voltlap::bms {

inline constexpr Duration kStep = Duration::from_ms(10);
inline constexpr std::uint32_t kSlowSteps = 10;  ///< estimation of resistance, steering of the charge: 10 Hz

[[nodiscard]] Output step(const Config& config, const Input& input, State& state);

}  // namespace voltlap::bms
