// SPDX-License-Identifier: Apache-2.0
// The rest voltage depends on the direction of the last current.
#include "discrepancy/cause.hpp"
#include "discrepancy/causes/list.hpp"

namespace voltlap::plant {

Cause hysteresis() {
  return {.name = "hysteresis",
          .balance = Balance::kVoltage,
          .says = "the rest voltage depends on the direction by {}",
          .test = "the same SOC reached by charge and by discharge, a rest of ten minutes at each",
          .parameters =
              {{"amplitude_v", "V", -0.1, 0.1, 0.01, 1e3, "mV", 5e-5}},
          .forms = [](const World&, const Comparison&) -> std::vector<Form> {
            return {plain_form(1, [](World& w, Values v) { w.car.cell.effects.hysteresis_v += v[0]; })};
          }};
}

}  // namespace voltlap::plant
