// SPDX-License-Identifier: Apache-2.0
// The charge transfer bends with the current (Butler-Volmer): exchange current other than the model has it.
#include "explain/causes/cause.hpp"
#include "explain/causes/list.hpp"

namespace voltlap::plant {

Cause resistance_current() {
  return {.name = "resistance_current",
          .balance = Balance::kVoltage,
          .says = "the exchange current differs by {}: the resistance bends with the current",
          .test = "pulses at three currents, up to the largest, at one temperature",
          .parameters = {{"exchange_current_change", "1", -0.9, 10, 0.3, 100, "%"}},
          .forms = [](const World&, const Comparison&) -> std::vector<Form> {
            return {plain_form(1, [](World& w, Values v) { w.car.cell.effects.exchange_current_change += v[0]; })};
          },
          .is_identified = true,
          .is_law_of_resistance = true};
}

}  // namespace voltlap::plant
