// SPDX-License-Identifier: Apache-2.0
#include "master/inverter_watch.hpp"

#include "base/require.hpp"

namespace voltlap::master {
namespace {

// Full current is forgotten in 100 ms, ten times what a current controller takes to follow a step.
constexpr std::int64_t kForgotten_ma_per_ms = 5'500;
constexpr Duration kTime = Duration::from_ms(200);

}  // namespace

void watch_inverter(const Config& config, const Input& input, InverterWatchState& state) {
  watch_current(input.phase_current, config.inverter_excess_max, input.now, state);
}

void watch_current(const Sample<Current>& current, Current excess_max, Instant now, InverterWatchState& state) {
  // A current controller's ripple and error and the resolution of its report are a few percent of its largest current.
  const bool unasked = current.good() && magnitude(current.value) > state.asked + excess_max;
  state.disobeys = state.unasked.held(unasked, now, kTime);
}

void note_asked(Current sent, Duration elapsed, InverterWatchState& state) {
  VOLTLAP_REQUIRE(elapsed >= Duration{});
  const Current forgotten = Current::saturated(kForgotten_ma_per_ms * elapsed.ms());
  state.asked = max(magnitude(sent), state.asked - forgotten);
  VOLTLAP_REQUIRE(state.asked >= Current{});
}

}  // namespace voltlap::master
