// SPDX-License-Identifier: Apache-2.0
// Cooling differs where the car stands: no airstream, or a fan.
#include "explain/causes/cause.hpp"
#include "explain/causes/list.hpp"

namespace voltlap::plant {

Cause cooling_at_stop() {
  return {.name = "cooling_at_stop",
          .balance = Balance::kHeat,
          .says = "cooling differs by {} while the car stands",
          .test = "a stop of five minutes with a hot battery, then driving on",
          .parameters = {{"change", "1", -0.95, 10, 0.3, 100, "%"}},
          .forms = [](const World&, const Comparison& c) -> std::vector<Form> {
            if (!has_temperature(c)) return {};
            bool some = false, all = true;
            for (const bool stopped : c.facts.stopped) {
              some = some || stopped;
              all = all && stopped;
            }
            if (!some || all) return {};
            return {plain_form(1, [](World& w, Values v) { w.cooling_at_stop_change += v[0]; })};
          }};
}

}  // namespace voltlap::plant
