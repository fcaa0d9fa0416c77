// SPDX-License-Identifier: Apache-2.0
// A share of the braking that the pedal asks is done by the motor, not by friction.
#include "discrepancy/cause.hpp"
#include "discrepancy/causes/list.hpp"

namespace voltlap::plant {

Cause regen_split() {
  return {.name = "regen_split",
          .balance = Balance::kForce,
          .says = "the friction brakes give {} less of what the pedal asks: the motor does it",
          .test = "light braking with the motor switched off and on",
          .parameters =
              {{"fraction", "1", -0.5, 1, 0.15, 100, "%"}},
          .forms = [](const World&, const Comparison& c) -> std::vector<Form> {
            if (c.find("speed") == nullptr || c.log.find("brake") == nullptr) return {};
            return {plain_form(1, [](World& w, Values v) { w.car.brakes.force_scale *= 1.0 - v[0]; })};
          }};
}

}  // namespace voltlap::plant
