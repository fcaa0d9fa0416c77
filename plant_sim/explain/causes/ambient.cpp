// SPDX-License-Identifier: Apache-2.0
// The air around the battery is warmer or colder than assumed.
#include "explain/causes/cause.hpp"
#include "explain/causes/list.hpp"

namespace voltlap::plant {

Cause ambient() {
  return {.name = "ambient",
          .balance = Balance::kHeat,
          .says = "the air around the battery differs by {} from what was assumed",
          .test = "a thermometer in the airstream",
          .parameters = {{"temperature_k", "K", -22, 22, 4, 1, "K"}},
          .forms = [](const World&, const Comparison& c) -> std::vector<Form> {
            if (!has_temperature(c)) return {};
            return {plain_form(1, [](World& w, Values v) { w.car.environment.ambient_c += v[0]; })};
          }};
}

}  // namespace voltlap::plant
