// SPDX-License-Identifier: Apache-2.0
// The driven tyres slip more or less for their force.
#include "explain/causes/cause.hpp"
#include "explain/causes/list.hpp"

namespace voltlap::plant {

Cause tyre_slip() {
  return {.name = "tyre_slip",
          .balance = Balance::kForce,
          .says = "tyre slip differs by {}",
          .test = "full-pedal pulls at two speeds with ground speed logged",
          .parameters = {{"change", "1", -0.9, 5, 0.3, 100, "%"}},
          .forms = [](const World&, const Comparison& c) -> std::vector<Form> {
            if (c.find("motor_speed") == nullptr) return {};
            return {plain_form(1, [](World& w, Values v) { w.slip_change += v[0]; })};
          }};
}

}  // namespace voltlap::plant
