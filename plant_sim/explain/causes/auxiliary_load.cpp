// SPDX-License-Identifier: Apache-2.0
// Something draws power all the time, at standstill too.
#include "explain/causes/cause.hpp"
#include "explain/causes/list.hpp"

namespace voltlap::plant {

Cause auxiliary_load() {
  return {.name = "auxiliary_load",
          .balance = Balance::kPower,
          .says = "something draws {} more all the time",
          .test = "a minute of standing with the tractive system on",
          .parameters = {{"power_w", "W", -2000, 5000, 150, 1, "W"}},
          .forms = [](const World&, const Comparison& c) -> std::vector<Form> {
            if (c.find("power") == nullptr) return {};
            return {plain_form(1, [](World& w, Values v) { w.car.low_voltage.power_w += v[0]; })};
          }};
}

}  // namespace voltlap::plant
