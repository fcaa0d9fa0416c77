// SPDX-License-Identifier: Apache-2.0
// A thermistor follows its cell late (first order).
#include "explain/causes/cause.hpp"
#include "explain/causes/list.hpp"

namespace voltlap::plant {
namespace {

constexpr double kLong_s = 120.0;

/// What a sensor that follows with this time constant reads beside the mean of what all read.
Eigen::VectorXd late(const Comparison& on, double delay_s) {
  const Eigen::VectorXd& all = on.facts.thermistor_c.size() > 0 ? on.facts.thermistor_c : on.facts.temperature_c;
  return delay_s > 0.0 ? Eigen::VectorXd(lagged(on.log.time_s, all, delay_s) - all)
                       : Eigen::VectorXd(Eigen::VectorXd::Zero(all.size()));
}

}  // namespace

Cause thermistor_lag() {
  return {
      .name = "thermistor_lag",
      .balance = Balance::kHeat,
      .says = "{channel} reads {} late",
      .test = "a minute of the hardest current, then a rest",
      .parameters = {{"delay_s", "s", 0, 900, 15, 1, "s"}},
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
          one.curved = [](const World&, const Comparison& on, const Prediction&, Values v) {
            return late(on, v[0]);
          };
          one.shapes = [](const World&, const Comparison& on, const Prediction&) -> std::vector<Eigen::VectorXd> {
            return {-thermistor_rate(on.log.time_s, on.facts)};
          };
          out.push_back(one);
          // As far as a sensor under tape follows: no straight line from nothing leads there.
          one.shapes = [](const World&, const Comparison& on, const Prediction&) -> std::vector<Eigen::VectorXd> {
            return {late(on, kLong_s) / kLong_s};
          };
          out.push_back(one);
        }
        return out;
      }};
}

}  // namespace voltlap::plant
