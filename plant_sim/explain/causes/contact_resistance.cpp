// SPDX-License-Identifier: Apache-2.0
// A contact between the cells and where the pack voltage is taken: follows the current only.
#include "explain/causes/cause.hpp"
#include "explain/causes/list.hpp"

namespace voltlap::plant {

Cause contact_resistance() {
  return {.name = "contact_resistance",
          .balance = Balance::kVoltage,
          .says = "a contact between cells and pack terminals has {} more",
          .test = "the pack voltage at its terminals against the sum of the cells under a hard pulse",
          .parameters = {{"resistance_ohm", "ohm", 0, 0.2, 3e-3, 1e3, "mOhm"}},
          .forms = [](const World&, const Comparison& c) -> std::vector<Form> {
            if (c.find("pack_voltage") == nullptr && c.find("bus_voltage") == nullptr) return {};
            return {plain_form(1, [](World& w, Values v) { w.pack_resistance_ohm += v[0]; })};
          },
          .is_identified = true};
}

}  // namespace voltlap::plant
