// SPDX-License-Identifier: Apache-2.0
// Reversible heat that the model does not have: follows the sign of the current.
#include "explain/causes/cause.hpp"
#include "explain/causes/list.hpp"

namespace voltlap::plant {

Cause entropic_heat() {
  return {.name = "entropic_heat",
          .balance = Balance::kHeat,
          .says = "reversible heat of {} (dOCV/dT) is not in the model",
          .test = "a discharge and a charge at the same current, the temperature logged",
          .parameters = {{"entropy_v_per_k", "V/K", -2e-3, 2e-3, 1.5e-4, 1e3, "mV/K"}},
          .forms = [](const World& model, const Comparison& c) -> std::vector<Form> {
            if (!has_temperature(c)) return {};
            return with_begun_soc(
                plain_form(1, [](World& w, Values v) { w.car.cell.effects.entropy_v_per_k += v[0]; }), model, c);
          }};
}

}  // namespace voltlap::plant
