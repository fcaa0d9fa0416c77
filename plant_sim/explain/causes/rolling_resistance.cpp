// SPDX-License-Identifier: Apache-2.0
// Rolling drag differs: constant.
#include "explain/causes/cause.hpp"
#include "explain/causes/list.hpp"

namespace voltlap::plant {

Cause rolling_resistance() {
  return {.name = "rolling_resistance",
          .balance = Balance::kForce,
          .says = "rolling resistance differs by {}",
          .test = "a coast-down at walking speed, both ways",
          .parameters = {{"change", "1", -0.9, 5, 0.3, 100, "%"}},
          .forms = [](const World&, const Comparison& c) -> std::vector<Form> {
            if (c.find("speed") == nullptr) return {};
            return {plain_form(1, [](World& w, Values v) { w.car.tyres.rolling_resistance *= 1.0 + v[0]; })};
          }};
}

}  // namespace voltlap::plant
