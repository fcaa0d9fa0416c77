// SPDX-License-Identifier: Apache-2.0
// A voltage sensor reads a constant too much: of the pack, or of one cell.
#include "explain/causes/cause.hpp"
#include "explain/causes/list.hpp"

namespace voltlap::plant {

Cause voltage_offset() {
  return {.name = "voltage_offset",
          .balance = Balance::kVoltage,
          .says = "{channel} reads {} too much all the time",
          .test = "a meter at the same terminals at rest",
          .parameters = {{"voltage_v", "V", -5, 5, 0.01, 1e3, "mV"}},
          .forms = [](const World&, const Comparison& c) -> std::vector<Form> {
            std::vector<Form> out;
            const bool own_sensor = c.find("pack_voltage") != nullptr || c.log.numbered("cell_voltage_").empty();
            if (own_sensor) {
              Form form = plain_form(1, [](World& w, Values v) { w.voltage.offset += v[0]; });
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
                static_cast<void>(p);
                return {Eigen::VectorXd::Ones(on.log.rows())};
              };
              out.push_back(one);
            }
            return out;
          }};
}

}  // namespace voltlap::plant
