// SPDX-License-Identifier: Apache-2.0
// The motor takes a share of the braking. The brake that is recorded is that of friction.
#include "explain/causes/cause.hpp"
#include "explain/causes/list.hpp"

namespace voltlap::plant {

Cause regen_split() {
  return {.name = "regen_split",
          .balance = Balance::kForce,
          .says = "the motor does {} of the braking",
          .test = "light braking with the motor switched off and on",
          .parameters = {{"fraction", "1", 0, 0.9, 0.05, 100, "%"}},
          .forms = [](const World&, const Comparison& c) -> std::vector<Form> {
            if (c.find("motor_torque") == nullptr) return {};
            return {plain_form(1, [](World& w, Values v) { w.regen_split += v[0]; })};
          }};
}

}  // namespace voltlap::plant
