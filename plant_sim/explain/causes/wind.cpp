// SPDX-License-Identifier: Apache-2.0
// Head wind on average.
#include "explain/causes/cause.hpp"
#include "explain/causes/list.hpp"

namespace voltlap::plant {

Cause wind() {
  return {.name = "wind",
          .balance = Balance::kForce,
          .says = "a head wind of {}",
          .test = "the same stretch both ways",
          .parameters = {{"speed_mps", "m/s", -15, 15, 1.5, 1, "m/s"}},
          .forms = [](const World&, const Comparison& c) -> std::vector<Form> {
            if (c.find("speed") == nullptr) return {};
            return {plain_form(1, [](World& w, Values v) { w.wind_mps += v[0]; })};
          }};
}

}  // namespace voltlap::plant
