// SPDX-License-Identifier: Apache-2.0
// More or less is lost between the battery and the shaft than the model says. What inverter and motor lose cannot
// be told apart from outside, so all of it changes by one share.
#include "explain/causes/cause.hpp"
#include "explain/causes/list.hpp"

namespace voltlap::plant {

Cause inverter_efficiency() {
  return {.name = "inverter_efficiency",
          .balance = Balance::kPower,
          .says = "the losses of inverter and motor differ by {}",
          .test = "constant power at three levels on a dynamometer, power in and torque out",
          .parameters = {{"change", "1", -0.95, 10, 0.3, 100, "%"}},
          .forms = [](const World& model, const Comparison& c) -> std::vector<Form> {
            if (c.find("power") == nullptr) return {};
            if (model.car.inverter.efficiency >= 1.0 && !model.car.motor.winding_loss) return {};
            return {plain_form(1, [](World& w, Values v) { w.loss_change += v[0]; })};
          }};
}

}  // namespace voltlap::plant
