// SPDX-License-Identifier: Apache-2.0
// All cells have more or less series resistance than the model: dV = -R I, at once.
#include "explain/causes/cause.hpp"
#include "explain/causes/list.hpp"

namespace voltlap::plant {

Cause series_resistance() {
  return {.name = "series_resistance",
          .balance = Balance::kVoltage,
          .says = "every cell's series resistance is {} off",
          .test = "pulses: a minute of hard on and off at one temperature and SOC",
          .parameters = {{"resistance_ohm", "ohm", -0.05, 0.05, 2e-4, 1e3, "mOhm", true}},
          .forms = [](const World&, const Comparison&) -> std::vector<Form> {
            return {plain_form(1, [](World& w, Values v) { w.car.cell.effects.series_ohm += v[0]; })};
          },
          .is_identified = true,
          .is_law_of_resistance = true,
          .present = cold_resistance};
}

}  // namespace voltlap::plant
