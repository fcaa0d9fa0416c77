// SPDX-License-Identifier: Apache-2.0
// Friction of the brakes falls as the rotors warm.
#include "discrepancy/cause.hpp"
#include "discrepancy/causes/list.hpp"

namespace voltlap::plant {

Cause brake_fade() {
  return {.name = "brake_fade",
          .balance = Balance::kForce,
          .says = "brake friction falls by {} of rotor temperature",
          .test = "ten stops from the same speed, one after the other",
          .parameters =
              {{"friction_per_k", "1/K", -5e-3, 5e-3, 5e-4, 100, "%/K"}},
          .forms = [](const World&, const Comparison& c) -> std::vector<Form> {
            if (c.find("speed") == nullptr || c.log.find("brake") == nullptr) return {};
            return {plain_form(1, [](World& w, Values v) { w.friction_per_k += v[0]; })};
          }};
}

}  // namespace voltlap::plant
