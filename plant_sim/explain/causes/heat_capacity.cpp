// SPDX-License-Identifier: Apache-2.0
// The battery takes more or less heat for a kelvin than the model says.
#include "explain/causes/cause.hpp"
#include "explain/causes/list.hpp"

namespace voltlap::plant {

Cause heat_capacity() {
  return {.name = "heat_capacity",
          .balance = Balance::kHeat,
          .says = "the heat capacity differs by {}",
          .test = "a minute of the hardest current from rest, the temperature logged",
          .parameters = {{"change", "1", -0.7, 3, 0.1, 100, "%"}},
          .forms = [](const World&, const Comparison& c) -> std::vector<Form> {
            if (!has_temperature(c)) return {};
            return {plain_form(1, [](World& w, Values v) { w.car.cell.heat_capacity_j_per_kg_k *= 1.0 + v[0]; })};
          }};
}

}  // namespace voltlap::plant
