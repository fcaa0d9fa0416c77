// SPDX-License-Identifier: Apache-2.0
// Resistances follow the temperature otherwise than the model says (Arrhenius).
#include "explain/causes/cause.hpp"
#include "explain/causes/list.hpp"

namespace voltlap::plant {

Cause resistance_temperature() {
  return {
      .name = "resistance_temperature",
      .balance = Balance::kVoltage,
      .says = "the resistances change with temperature by {} of activation energy more than the model says",
      .test = "the same pulse on a cold and on a hot battery",
      .parameters = {{"activation_energy_j_per_mol", "J/mol", -40000, 40000, 8000, 1e-3, "kJ/mol"}},
      .forms = [](const World&, const Comparison&) -> std::vector<Form> {
        return {plain_form(1, [](World& w, Values v) { w.car.cell.effects.activation_energy_j_per_mol += v[0]; })};
      },
      .is_identified = true,
      .is_law_of_resistance = true};
}

}  // namespace voltlap::plant
