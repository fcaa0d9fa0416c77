// SPDX-License-Identifier: Apache-2.0
// The rest voltage depends on the direction of the last current.
#include "explain/causes/cause.hpp"
#include "explain/causes/list.hpp"

namespace voltlap::plant {

Cause hysteresis() {
  return {.name = "hysteresis",
          .balance = Balance::kVoltage,
          .says = "the rest voltage depends on the direction by {}",
          .test = "the same SOC reached by charge and by discharge, a rest of ten minutes at each",
          .parameters = {{"amplitude_v", "V", -0.1, 0.1, 0.01, 1e3, "mV"}, {"turns_per_soc", "1", 5, 200, 20}},
          .forms = [](const World& model, const Comparison&) -> std::vector<Form> {
            // How fast it turns decides how much of it a drive shows; a model that has it says so itself.
            const CellEffects& given = model.car.cell.effects;
            std::vector<double> turns{given.hysteresis_per_soc};
            if (given.hysteresis_v == 0.0) turns = {15.0, 50.0};
            std::vector<Form> out;
            for (const double per_soc : turns) {
              Form form = plain_form(2, [](World& w, Values v) {
                w.car.cell.effects.hysteresis_v += v[0];
                w.car.cell.effects.hysteresis_per_soc = v[1];
              });
              form.at[1] = per_soc;
              form.linear = {0};
              out.push_back(form);
            }
            return out;
          },
          .reported = {{"amplitude_v", "V", -0.1, 0.1, 0.01, 1e3, "mV"}},
          .report = [](Values v) -> std::vector<double> { return {v[0]}; },
          .present = [](const CellParameters& cell) { return cell.effects.hysteresis_v; }};
}

}  // namespace voltlap::plant
