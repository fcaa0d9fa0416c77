// SPDX-License-Identifier: Apache-2.0
// A contact between the cells and where the pack voltage is taken, or from there to the bus: follows the current only.
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
            std::vector<Form> out{plain_form(1, [](World& w, Values v) { w.pack_resistance_ohm += v[0]; })};
            if (c.find("pack_voltage") == nullptr || c.find("bus_voltage") == nullptr) return out;
            out.push_back(plain_form(1, [](World& w, Values v) { w.car.contactors.resistance_ohm += v[0]; }));
            out.back().says = "contactors, fuse or cables between the pack voltage and the bus have {} more";
            return out;
          },
          .is_identified = true};
}

}  // namespace voltlap::plant
