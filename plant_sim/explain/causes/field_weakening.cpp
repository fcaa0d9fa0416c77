// SPDX-License-Identifier: Apache-2.0
// The speed above which the field is weakened is another one: beyond it a current flows that only warms. Where no
// torque is recorded, the torque falls from there too.
#include "explain/causes/cause.hpp"
#include "explain/causes/list.hpp"

namespace voltlap::plant {

Cause field_weakening() {
  return {.name = "field_weakening",
          .balance = Balance::kPower,
          .says = "the motor's field is weakened from a speed that is {} off",
          .test = "full pedal up to top speed",
          .parameters = {{"base_speed_change", "1", -0.5, 0.5, 0.05, 100, "%"}},
          .forms = [](const World&, const Comparison& c) -> std::vector<Form> {
            if (c.find("power") == nullptr) return {};
            return {plain_form(1, [](World& w, Values v) { w.base_speed_change += v[0]; })};
          }};
}

}  // namespace voltlap::plant
