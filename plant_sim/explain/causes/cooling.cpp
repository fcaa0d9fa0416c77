// SPDX-License-Identifier: Apache-2.0
// The battery loses heat to the air faster or slower than the model says.
#include "explain/causes/cause.hpp"
#include "explain/causes/list.hpp"

namespace voltlap::plant {

Cause cooling() {
  return {.name = "cooling",
          .balance = Balance::kHeat,
          .says = "cooling differs by {}",
          .test = "half an hour of standing with a hot battery",
          .parameters = {{"change", "1", -0.95, 10, 0.2, 100, "%"}},
          .forms = [](const World&, const Comparison& c) -> std::vector<Form> {
            if (!has_temperature(c)) return {};
            return {plain_form(1, [](World& w, Values v) { w.car.cell.convection_w_per_m2_k *= 1.0 + v[0]; })};
          }};
}

}  // namespace voltlap::plant
