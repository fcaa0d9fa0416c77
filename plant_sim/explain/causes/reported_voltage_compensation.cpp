// SPDX-License-Identifier: Apache-2.0
// A BMS that adds I R to the pack voltage it publishes, at once, late, or behind one filter with the voltage:
//
//   published = V + R I,   V + L(R I)   or   V + L(R I) + s (L(V) - V)     L: first order, s: near 1
//
// Cells beside it tell it from the cells' own resistance, or a bus behind the contactors.
#include "explain/causes/cause.hpp"
#include "explain/causes/list.hpp"

namespace voltlap::plant {
namespace {

Form filtered(bool with_voltage, double tau_s) {
  Form form = plain_form(3, [](World& w, Values v) {
    w.published_compensation_ohm += v[0];
    w.published_tau_s = v[1];
    w.published_filtered = v[2];
  });
  form.at[1] = tau_s;
  form.linear = with_voltage ? std::vector<std::size_t>{0, 2} : std::vector<std::size_t>{0};
  form.refined = with_voltage ? std::vector<std::size_t>{0, 1, 2} : std::vector<std::size_t>{0, 1};
  form.says = with_voltage
                  ? "the published pack voltage has I times {} added to it, behind a filter of {} that {} of the "
                    "voltage pass as well"
                  : "the published pack voltage has I times {} added to it, behind a filter of {}";
  return form;
}

}  // namespace

Cause reported_voltage_compensation() {
  return {.name = "reported_voltage_compensation",
          .balance = Balance::kVoltage,
          .says = "the published pack voltage has I times {} added to it",
          .test = "a bus voltage beside it under a hard pulse",
          .parameters = {{"resistance_ohm", "ohm", 0, 2, 5e-3, 1e3, "mOhm"},
                         {"tau_s", "s", 0.02, 60, 1, 1, "s"},
                         {"filtered_share", "1", -0.5, 1.5, 0.5, 100, "%"}},
          .forms = [](const World&, const Comparison& c) -> std::vector<Form> {
            const bool beside = !c.log.numbered("cell_voltage_").empty() || c.find("bus_voltage") != nullptr;
            if (!beside || c.find("pack_voltage") == nullptr) return {};
            Form at_once = plain_form(1, [](World& w, Values v) { w.published_compensation_ohm += v[0]; });
            at_once.at.resize(3, 0.0);
            std::vector<Form> out{at_once};
            // Cells of other times than the current's tell of no filter.
            if (c.log.pack_is_nearer && c.find("bus_voltage") == nullptr) return out;
            for (const double tau_s : {0.3, 2.0}) {
              out.push_back(filtered(false, tau_s));
              out.push_back(filtered(true, tau_s));
            }
            return out;
          }};
}

}  // namespace voltlap::plant
