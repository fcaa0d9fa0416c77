// SPDX-License-Identifier: Apache-2.0
// A BMS that adds I R to the pack voltage it publishes: published rises with the current.
#include "explain/causes/cause.hpp"
#include "explain/causes/list.hpp"

namespace voltlap::plant {

Cause reported_voltage_compensation() {
  return {.name = "reported_voltage_compensation",
          .balance = Balance::kVoltage,
          .says = "the published pack voltage has I times {} added to it",
          .test = "a bus voltage beside it under a hard pulse",
          .parameters = {{"resistance_ohm", "ohm", 0, 0.3, 5e-3, 1e3, "mOhm"}},
          .forms = [](const World&, const Comparison& c) -> std::vector<Form> {
            if (c.log.numbered("cell_voltage_").empty() || c.find("pack_voltage") == nullptr) return {};
            return {plain_form(1, [](World& w, Values v) { w.published_compensation_ohm += v[0]; })};
          }};
}

}  // namespace voltlap::plant
