// SPDX-License-Identifier: Apache-2.0
// Resistances rise at the low end of SOC otherwise than the model says.
#include "explain/causes/cause.hpp"
#include "explain/causes/list.hpp"

namespace voltlap::plant {

Cause resistance_soc() {
  return {.name = "resistance_soc",
          .balance = Balance::kVoltage,
          .says = "the resistances at the low end of the charge are {} off",
          .test = "the same pulse at 50 % and at 10 % SOC",
          .parameters = {{"low_end_change", "1", -0.9, 10, 0.5, 100, "%"}},
          .forms = [](const World& model, const Comparison& c) -> std::vector<Form> {
            if (c.log.rows() == 0 || driven_soc(model, c).minCoeff() > 0.28) return {};
            return {plain_form(1, [](World& w, Values v) { w.car.cell.effects.low_end_change += v[0]; })};
          },
          .is_identified = true,
          .is_law_of_resistance = true};
}

}  // namespace voltlap::plant
