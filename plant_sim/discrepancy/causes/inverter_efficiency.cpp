// SPDX-License-Identifier: Apache-2.0
// The inverter loses another share of its power than the model says; change of its losses.
#include "discrepancy/cause.hpp"
#include "discrepancy/causes/list.hpp"

namespace voltlap::plant {

Cause inverter_efficiency() {
  return {.name = "inverter_efficiency",
          .balance = Balance::kPower,
          .says = "the inverter's losses differ by {}",
          .test = "constant power at three levels on a dynamometer, power in and torque out",
          .parameters =
              {{"change", "1", -0.95, 10, 0.3, 100, "%", 0.03}},
          .forms = [](const World& model, const Comparison& c) -> std::vector<Form> {
            if (c.find("power") == nullptr) return {};
            if (model.car.inverter.efficiency >= 1.0) return {};
            return {plain_form(1, [](World& w, Values v) { w.loss_change += v[0]; })};
          }};
}

}  // namespace voltlap::plant
