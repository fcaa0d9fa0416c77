// SPDX-License-Identifier: Apache-2.0
// A voltage sensor reads a share too much: of the pack, or of one cell.
#include "explain/causes/cause.hpp"
#include "explain/causes/list.hpp"

namespace voltlap::plant {

Cause voltage_gain() {
  return {.name = "voltage_gain",
          .balance = Balance::kVoltage,
          .says = "{channel} reads {} too much",
          .test = "a meter at the same terminals at two voltages",
          .parameters = {{"change", "1", -0.1, 0.1, 5e-3, 100, "%"}},
          .forms = [](const World&, const Comparison& c) -> std::vector<Form> {
            std::vector<Form> out;
            const bool own_sensor = c.find("pack_voltage") != nullptr || c.log.numbered("cell_voltage_").empty();
            if (own_sensor) {
              Form form = plain_form(1, [](World& w, Values v) { w.voltage.gain += v[0]; });
              form.channel = c.find("pack_voltage") != nullptr ? "pack_voltage" : c.channels.front().name;
              out.push_back(form);
            }
            if (!c.log.numbered("cell_voltage_").empty() && c.log.numbered("cell_voltage_").size() > 1) {
              Form one;
              one.stem = "cell_voltage_";
              one.of_sensor = true;
              one.at = {0.0};
              one.linear = one.refined = {0};
              one.shapes = [](const World&, const Comparison& on,
                              const Prediction& p) -> std::vector<Eigen::VectorXd> {
                static_cast<void>(on);
                return {p.battery.voltage_v};
              };
              out.push_back(one);
            }
            return out;
          }};
}

}  // namespace voltlap::plant
