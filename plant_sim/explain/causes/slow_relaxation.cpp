// SPDX-License-Identifier: Apache-2.0
// Slow relaxation: diffusion that the branches of the model do not reach, tau 150 to 1500 s.
#include "explain/causes/cause.hpp"
#include "explain/causes/list.hpp"

namespace voltlap::plant {

Cause slow_relaxation() {
  return {.name = "slow_relaxation",
          .balance = Balance::kVoltage,
          .says = "the cells relax by {} with a time constant of {} that the model does not have",
          .test = "a rest of half an hour after the hardest stretch",
          .parameters = {{"resistance_ohm", "ohm", -0.05, 0.05, 3e-4, 1e3, "mOhm", true},
                         {"tau_s", "s", 50, 3000, 500, 1, "s"}},
          .forms = [](const World&, const Comparison&) -> std::vector<Form> {
            std::vector<Form> out;
            for (const double tau : {150.0, 300.0, 600.0, 1500.0}) {
              Form form = plain_form(2, [](World& w, Values v) {
                w.car.cell.effects.slow_relaxation_ohm += v[0];
                w.car.cell.effects.slow_relaxation_tau_s = v[1];
              });
              form.at[1] = tau;
              form.linear = {0};
              out.push_back(form);
            }
            return out;
          },
          .is_identified = true,
          .present = [](const CellParameters& cell) { return cell.effects.slow_relaxation_ohm; }};
}

}  // namespace voltlap::plant
