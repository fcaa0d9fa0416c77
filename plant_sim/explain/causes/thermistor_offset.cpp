// SPDX-License-Identifier: Apache-2.0
// A thermistor reads a constant too much.
#include "explain/causes/cause.hpp"
#include "explain/causes/list.hpp"

namespace voltlap::plant {

Cause thermistor_offset() {
  return {.name = "thermistor_offset",
          .balance = Balance::kHeat,
          .says = "{channel} reads {} too much",
          .test = "all thermistors after a night in one room",
          .parameters = {{"temperature_k", "K", -20, 20, 1, 1, "K"}},
          .forms = [](const World&, const Comparison& c) -> std::vector<Form> {
            std::vector<Form> out;
            if (!has_temperature(c)) return out;
            if (c.log.numbered("temperature_").size() == 1) {
              Form all = plain_form(1, [](World& w, Values v) { w.thermistor_offset_k += v[0]; });
              all.channel = "temperature_1";
              out.push_back(all);
            } else {
              Form one;
              one.stem = "temperature_";
              one.at = {0.0};
              one.linear = one.refined = {0};
              one.shapes = [](const World&, const Comparison& on,
                              const Prediction&) -> std::vector<Eigen::VectorXd> {
                return {Eigen::VectorXd::Ones(on.log.rows())};
              };
              out.push_back(one);
            }
            return out;
          }};
}

}  // namespace voltlap::plant
