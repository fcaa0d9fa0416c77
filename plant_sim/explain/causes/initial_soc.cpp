// SPDX-License-Identifier: Apache-2.0
// The battery started at another SOC than stated or than its first rest says.
#include "explain/causes/cause.hpp"
#include "explain/causes/list.hpp"

namespace voltlap::plant {

Cause initial_soc() {
  return {.name = "initial_soc",
          .balance = Balance::kCharge,
          .says = "the battery started {} of SOC off",
          .test = "a rest of ten minutes before the start",
          .parameters = {{"soc", "1", -0.5, 0.5, 0.02, 100, "%"}},
          .forms = [](const World&, const Comparison& c) -> std::vector<Form> {
            // A rest at the beginning tells the charge; what can be wrong then is what the log says of it.
            if (c.find("soc") != nullptr)
              return {plain_form(1, [](World& w, Values v) { w.reported_soc_low += v[0]; })};
            return {plain_form(1, [](World& w, Values v) { w.initial_soc_change += v[0]; })};
          }};
}

}  // namespace voltlap::plant
