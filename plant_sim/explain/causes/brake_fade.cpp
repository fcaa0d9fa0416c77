// SPDX-License-Identifier: Apache-2.0
// Friction of the brakes changes as the rotors warm.
#include "explain/causes/cause.hpp"
#include "explain/causes/list.hpp"

namespace voltlap::plant {

Cause brake_fade() {
  return {.name = "brake_fade",
          .balance = Balance::kForce,
          .says = "brake friction changes by {} of rotor temperature",
          .test = "ten stops from the same speed, one after the other",
          .parameters = {{"friction_per_k", "1/K", -5e-3, 5e-3, 5e-4, 100, "%/K"}},
          .forms = [](const World&, const Comparison& c) -> std::vector<Form> {
            if (c.find("speed") == nullptr || c.log.find("brake") == nullptr) return {};
            // Nobody weighs rotors: those of the model, and such as need ten times as long to cool.
            const auto with_rotors = [](double mass) {
              return plain_form(1, [mass](World& w, Values v) {
                w.friction_per_k += v[0];
                if (v[0] == 0.0) return;
                w.car.brakes.front_rotor_mass_kg *= mass;
                w.car.brakes.rear_rotor_mass_kg *= mass;
              });
            };
            return {with_rotors(1.0), with_rotors(10.0)};
          }};
}

}  // namespace voltlap::plant
