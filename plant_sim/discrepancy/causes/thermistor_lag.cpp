// SPDX-License-Identifier: Apache-2.0
// A thermistor follows its cell late (first order).
#include "discrepancy/cause.hpp"
#include "discrepancy/causes/list.hpp"

namespace voltlap::plant {

Cause thermistor_lag() {
  return {.name = "thermistor_lag",
          .balance = Balance::kHeat,
          .says = "{channel} reads {} late",
          .test = "a minute of the hardest current, then a rest",
          .parameters =
              {{"delay_s", "s", 0, 300, 15, 1, "s", 0.06, 1}},
          .forms = [](const World&, const Comparison& c) -> std::vector<Form> {
            std::vector<Form> out;
            if (!has_temperature(c)) return out;
            if (c.log.numbered("temperature_").size() == 1) {
              Form all = plain_form(1, [](World& w, Values v) { w.thermistor_delay_s += v[0]; });
              all.channel = "temperature_1";
              out.push_back(all);
            } else {
              Form all = plain_form(1, [](World& w, Values v) { w.thermistor_delay_s += v[0]; });
              all.channel = "temperature";
              out.push_back(all);
              Form one;
              one.stem = "temperature_";
              one.at = {0.0};
              one.linear = one.refined = {0};
              one.shapes = [](const World&, const Comparison& on, const Prediction&) -> std::vector<Eigen::VectorXd> {
                return {-rate_of_change(on.log.time_s, on.facts.temperature_c)};
              };
              out.push_back(one);
            }
            return out;
          }};
}

}  // namespace voltlap::plant
