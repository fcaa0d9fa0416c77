// SPDX-License-Identifier: Apache-2.0
#include "master/inverter_watch.hpp"

#include "base/require.hpp"

namespace voltlap::master {
namespace {

// Full current is forgotten in 100 ms, ten times what a current controller takes to follow a step.
constexpr std::int64_t kForgotten_ma_per_ms = 5'500;
constexpr Duration kTime = Duration::from_ms(200);

Current magnitude(Current c) { return c < Current{} ? -c : c; }

}  // namespace

void watch_inverter(const Config& config, const Input& input, InverterWatchState& state) {
  // A current controller's ripple and error and the resolution of its report are a few percent of its largest current.
  const bool unasked = input.phase_current.good() &&
                       magnitude(input.phase_current.value) > state.asked + config.inverter_excess_max;
  state.disobeys = state.unasked.held(unasked, input.now, kTime);
}

void note_asked(Current sent, Duration elapsed, InverterWatchState& state) {
  const Current forgotten = Current::saturated(kForgotten_ma_per_ms * (elapsed.ms() > 0 ? elapsed.ms() : 0));
  state.asked = max(magnitude(sent), state.asked - forgotten);
  VOLTLAP_REQUIRE(state.asked >= Current{});
}

}  // namespace voltlap::master
