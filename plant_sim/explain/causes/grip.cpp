// SPDX-License-Identifier: Apache-2.0
// The tyres hold more or less than the model says: the driven wheels slip more as they come near to the limit, and
// brakes end there.
#include "explain/causes/cause.hpp"
#include "explain/causes/list.hpp"

namespace voltlap::plant {

Cause grip() {
  return {.name = "grip",
          .balance = Balance::kForce,
          .says = "grip differs by {}",
          .test = "a full stop from speed",
          .parameters = {{"change", "1", -0.6, 0.6, 0.1, 100, "%"}},
          .forms = [](const World&, const Comparison& c) -> std::vector<Form> {
            const bool brakes = c.find("speed") != nullptr && c.log.find("brake") != nullptr;
            if (c.find("motor_speed") == nullptr && !brakes) return {};
            return {plain_form(1, [](World& w, Values v) { w.grip_change += v[0]; })};
          }};
}

}  // namespace voltlap::plant
