// SPDX-License-Identifier: Apache-2.0
// Polarization that follows the current with a lag of 1 to 60 s: a branch more (or less) than the model has.
#include "explain/causes/cause.hpp"
#include "explain/causes/list.hpp"

namespace voltlap::plant {

Cause polarization_resistance() {
  return {.name = "polarization_resistance",
          .balance = Balance::kVoltage,
          .says = "polarization of {} with a lag of {} is not as the model has it",
          .test = "a pulse of a minute, then a rest of five",
          .parameters = {{"resistance_ohm", "ohm", -0.05, 0.05, 3e-4, 1e3, "mOhm", true},
                         {"tau_s", "s", 0.5, 200, 10, 1, "s"}},
          .forms = [](const World&, const Comparison&) -> std::vector<Form> {
            std::vector<Form> out;
            for (const double tau : {1.5, 4.0, 10.0, 25.0, 60.0}) {
              Form form = plain_form(2, [](World& w, Values v) {
                w.car.cell.effects.polarization_ohm += v[0];
                w.car.cell.effects.polarization_tau_s = v[1];
              });
              form.at[1] = tau;
              form.linear = {0};
              out.push_back(form);
            }
            return out;
          },
          .is_identified = true,
          .present = cold_resistance};
}

}  // namespace voltlap::plant
