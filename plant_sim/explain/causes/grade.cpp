// SPDX-License-Identifier: Apache-2.0
// The course climbs or falls on average.
#include "explain/causes/cause.hpp"
#include "explain/causes/list.hpp"

namespace voltlap::plant {

Cause grade() {
  return {.name = "grade",
          .balance = Balance::kForce,
          .says = "the course climbs by {}",
          .test = "the same stretch both ways",
          .parameters = {{"slope", "1", -0.1, 0.1, 5e-3, 100, "%"}},
          .forms = [](const World&, const Comparison& c) -> std::vector<Form> {
            if (c.find("speed") == nullptr) return {};
            return {plain_form(1, [](World& w, Values v) { w.slope += v[0]; })};
          }};
}

}  // namespace voltlap::plant
