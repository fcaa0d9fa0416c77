// SPDX-License-Identifier: Apache-2.0
// The rolling radius differs: motor speed against ground speed.
#include "explain/causes/cause.hpp"
#include "explain/causes/list.hpp"

namespace voltlap::plant {

Cause tyre_radius() {
  return {.name = "tyre_radius",
          .balance = Balance::kForce,
          .says = "the tyres' rolling radius differs by {}",
          .test = "ten turns of a wheel, measured with a tape",
          .parameters = {{"change", "1", -0.15, 0.15, 0.015, 100, "%"}},
          .forms = [](const World&, const Comparison& c) -> std::vector<Form> {
            const bool reckoned = c.log.derived.contains("motor_speed") && c.find("power") != nullptr;
            if (c.find("motor_speed") == nullptr && !reckoned) return {};
            return {plain_form(1, [](World& w, Values v) { w.car.tyres.radius_m *= 1.0 + v[0]; })};
          }};
}

}  // namespace voltlap::plant
