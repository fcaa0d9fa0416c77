// SPDX-License-Identifier: Apache-2.0
// The car is heavier or lighter than the model: follows the acceleration.
#include "car/vehicle/chassis.hpp"
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
              VehicleSection& car = w.car.vehicle;
              (car.mass_kg > 0.0 ? car.mass_kg : car.mass_without_pack_kg) += v[0] * total_mass(w.car);
            })};
          }};
}

}  // namespace voltlap::plant
