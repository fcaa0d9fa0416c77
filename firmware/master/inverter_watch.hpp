// SPDX-License-Identifier: Apache-2.0
// MST-041: whether the inverter drives more current than it was asked for.
//   |I| > I_asked + I_margin for T; I_asked the greatest command, forgotten at a steady rate
#pragma once
#include "base/leaky_persistence.hpp"
#include "master/config.hpp"
#include "master/io.hpp"

namespace voltlap::master {

struct InverterWatchState {
  Current asked{};  ///< the greatest magnitude that was asked for, as far as it is remembered
  LeakyPersistence unasked;
  bool disobeys = false;
};

/// By what was asked until the last step.
void watch_inverter(const Config& config, const Input& input, InverterWatchState& state);
void watch_current(const Sample<Current>& current, Current excess_max, Instant now, InverterWatchState& state);

/// What is sent now.
void note_asked(Current sent, Duration elapsed, InverterWatchState& state);

}  // namespace voltlap::master
