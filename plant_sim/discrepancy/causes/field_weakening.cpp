// SPDX-License-Identifier: Apache-2.0
// The speed above which the torque falls is another one; shows where no torque is recorded.
#include "discrepancy/cause.hpp"
#include "discrepancy/causes/list.hpp"

namespace voltlap::plant {

Cause field_weakening() {
  return {.name = "field_weakening",
          .balance = Balance::kPower,
          .says = "the motor's torque falls from a speed that is {} off",
          .test = "full pedal up to top speed",
          .parameters =
              {{"base_speed_change", "1", -0.5, 0.5, 0.05, 100, "%"}},
          .forms = [](const World&, const Comparison& c) -> std::vector<Form> {
            if (c.find("speed") == nullptr || c.log.find("motor_torque") != nullptr || c.log.find("motor_speed") == nullptr) return {};
            return {plain_form(1, [](World& w, Values v) { w.base_speed_change += v[0]; })};
          }};
}

}  // namespace voltlap::plant
