// SPDX-License-Identifier: Apache-2.0
// A warm motor gives another torque for its current, mostly less.
#include "explain/causes/cause.hpp"
#include "explain/causes/list.hpp"

namespace voltlap::plant {

Cause motor_temperature() {
  return {.name = "motor_temperature",
          .balance = Balance::kPower,
          .says = "torque changes by {} of winding temperature",
          .test = "the same full-pedal pull with a cold and a hot motor",
          .parameters = {{"torque_per_k", "1/K", -0.01, 0.01, 1e-3, 100, "%/K"}},
          .forms = [](const World&, const Comparison& c) -> std::vector<Form> {
            if (c.find("speed") == nullptr || c.log.find("motor_speed") == nullptr) return {};
            return {plain_form(1, [](World& w, Values v) { w.torque_per_k += v[0]; })};
          }};
}

}  // namespace voltlap::plant
