// SPDX-License-Identifier: Apache-2.0
// The car is heavier or lighter than the model: follows the acceleration.
#include "explain/causes/cause.hpp"
#include "explain/causes/list.hpp"

namespace voltlap::plant {

Cause mass() {
  return {.name = "mass",
          .balance = Balance::kForce,
          .says = "the car's mass (with driver) differs by {}",
          .test = "scales",
          .parameters = {{"change", "1", -0.4, 0.6, 0.05, 100, "%"}},
          .forms = [](const World&, const Comparison& c) -> std::vector<Form> {
            if (c.find("speed") == nullptr) return {};
            return {plain_form(1, [](World& w, Values v) {
              const double total = w.car.vehicle.mass_kg + w.car.vehicle.driver_mass_kg;
              w.car.vehicle.mass_kg += v[0] * total;
            })};
          }};
}

}  // namespace voltlap::plant
