// SPDX-License-Identifier: Apache-2.0
// Torque for a phase current differs from what the inverter reports with its own constant.
#include "explain/causes/cause.hpp"
#include "explain/causes/list.hpp"

namespace voltlap::plant {

Cause motor_constant() {
  return {.name = "motor_constant",
          .balance = Balance::kPower,
          .says = "the motor's torque for its current differs by {}",
          .test = "torque on a dynamometer at two currents",
          .parameters = {{"change", "1", -0.5, 0.5, 0.05, 100, "%"}},
          .forms = [](const World&, const Comparison& c) -> std::vector<Form> {
            if (c.find("power") == nullptr && c.find("speed") == nullptr) return {};
            return {plain_form(1, [](World& w, Values v) { w.torque_change += v[0]; })};
          }};
}

}  // namespace voltlap::plant
