// SPDX-License-Identifier: Apache-2.0
// A channel is late against the others; follows dI/dt.
#include "explain/causes/cause.hpp"
#include "explain/causes/list.hpp"

namespace voltlap::plant {

Cause time_skew() {
  return {.name = "time_skew",
          .balance = Balance::kVoltage,
          .says = "{channel} is {} late",
          .test = "sharp steps of the current, logged at the highest rate",
          .parameters = {{"delay_s", "s", 0, 2, 0.05, 1e3, "ms"}},
          .forms = [](const World&, const Comparison& c) -> std::vector<Form> {
            std::vector<Form> out;
            Form current = plain_form(1, [](World& w, Values v) { w.current.delay_s += v[0]; });
            current.channel = "current";
            out.push_back(current);
            if (c.find("pack_voltage") != nullptr || c.log.numbered("cell_voltage_").empty()) {
              Form voltage = plain_form(1, [](World& w, Values v) { w.voltage.delay_s += v[0]; });
              voltage.channel = c.find("pack_voltage") != nullptr ? "pack_voltage" : c.channels.front().name;
              out.push_back(voltage);
            }
            if (!c.log.numbered("cell_voltage_").empty() && c.log.numbered("cell_voltage_").size() > 1) {
              Form one;
              one.stem = "cell_voltage_";
              one.of_sensor = true;
              one.at = {0.0};
              one.linear = one.refined = {0};
              one.shapes = [](const World&, const Comparison& on,
                              const Prediction& p) -> std::vector<Eigen::VectorXd> {
                constexpr double kStep = 0.05;
                return {(shifted(on.log.time_s, p.battery.voltage_v, -kStep) - p.battery.voltage_v) / kStep};
              };
              out.push_back(one);
            }
            return out;
          }};
}

}  // namespace voltlap::plant
