// SPDX-License-Identifier: Apache-2.0
// The current sensor reads a share too much: voltage, charge and power balance together.
#include "explain/causes/cause.hpp"
#include "explain/causes/list.hpp"

namespace voltlap::plant {

Cause current_gain() {
  return {.name = "current_gain",
          .balance = Balance::kCharge,
          .says = "the current sensor reads {} too much",
          .test = "a second current sensor, or the charge counter of a charger over a full charge",
          .parameters = {{"change", "1", -0.2, 0.2, 0.015, 100, "%"}},
          .forms = [](const World&, const Comparison& c) -> std::vector<Form> {
            return with_counted_soc(plain_form(1, [](World& w, Values v) { w.current.gain += v[0]; }), c);
          }};
}

}  // namespace voltlap::plant
