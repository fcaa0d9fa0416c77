// SPDX-License-Identifier: Apache-2.0
// All cells hold more or less charge than the model says; grows with the charge drawn.
#include "explain/causes/cause.hpp"
#include "explain/causes/list.hpp"

namespace voltlap::plant {

Cause capacity() {
  return {.name = "capacity",
          .balance = Balance::kCharge,
          .says = "the cells hold {} more charge than the model says",
          .test = "a rest of ten minutes at both ends of a deep discharge",
          .parameters = {{"change", "1", -0.5, 0.5, 0.05, 100, "%"}},
          .forms = [](const World&, const Comparison& c) -> std::vector<Form> {
            return with_counted_soc(plain_form(1, [](World& w, Values v) { w.car.cell.capacity_ah *= 1.0 + v[0]; }),
                                    c);
          }};
}

}  // namespace voltlap::plant
