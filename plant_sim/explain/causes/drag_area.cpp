// SPDX-License-Identifier: Apache-2.0
// The air holds the car more or less than the model says: v squared.
#include "explain/causes/cause.hpp"
#include "explain/causes/list.hpp"

namespace voltlap::plant {

Cause drag_area() {
  return {.name = "drag_area",
          .balance = Balance::kForce,
          .says = "drag area differs by {}",
          .test = "coast-downs from top speed, both ways",
          .parameters = {{"change", "1", -0.9, 3, 0.15, 100, "%"}},
          .forms = [](const World&, const Comparison& c) -> std::vector<Form> {
            if (c.find("speed") == nullptr) return {};
            return {plain_form(1, [](World& w, Values v) { w.car.aero.drag_coefficient *= 1.0 + v[0]; })};
          }};
}

}  // namespace voltlap::plant
