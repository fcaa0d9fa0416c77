// SPDX-License-Identifier: Apache-2.0
// The tyres hold more or less than the model says; shows where brakes are at the limit.
#include "discrepancy/cause.hpp"
#include "discrepancy/causes/list.hpp"

namespace voltlap::plant {

Cause grip() {
  return {.name = "grip",
          .balance = Balance::kForce,
          .says = "grip differs by {}",
          .test = "a full stop from speed",
          .parameters =
              {{"change", "1", -0.6, 0.6, 0.1, 100, "%", 0.02}},
          .forms = [](const World&, const Comparison& c) -> std::vector<Form> {
            if (c.find("speed") == nullptr || c.log.find("brake") == nullptr) return {};
            return {plain_form(1, [](World& w, Values v) { w.grip_change += v[0]; })};
          }};
}

}  // namespace voltlap::plant
