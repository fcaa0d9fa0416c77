// SPDX-License-Identifier: Apache-2.0
// A channel is late against the others; follows dI/dt.
#include <cmath>

#include "discrepancy/cause.hpp"
#include "discrepancy/causes/list.hpp"

namespace voltlap::plant {
namespace {

/// Delay that noise of the readings seems to be: a difference of readings holds it as the error behind them does.
double seeming_delay_s(const Recording& log, double deviation_a) {
  const Eigen::VectorXd& current = *log.find("current");
  double square = 0.0, rows = 0.0;
  for (Eigen::Index k = 1; k < current.size(); ++k) {
    const double step = current(k) - current(k - 1);
    if (!std::isfinite(step)) continue;
    square += step * step;
    rows += 1.0;
  }
  const double row_s = (log.time_s(log.time_s.size() - 1) - log.time_s(0)) / static_cast<double>(log.time_s.size() - 1);
  return square > 0.0 ? row_s * deviation_a * deviation_a * rows / square : 0.0;
}

}  // namespace

Cause time_skew() {
  return {.name = "time_skew",
          .balance = Balance::kVoltage,
          .says = "{channel} is {} late",
          .test = "sharp steps of the current, logged at the highest rate",
          .parameters =
              // A cell beside its pack seems later or earlier by a part of a millisecond on another day.
              {{"delay_s", "s", 0, 2, 0.05, 1e3, "ms", 5e-5, 1e-3, false, 3e-4}},
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
              one.shapes = [](const World&, const Comparison& on, const Prediction& p) -> std::vector<Eigen::VectorXd> {
                constexpr double kStep = 0.05;
                return {(shifted(on.log.time_s, p.battery.voltage_v, -kStep) - p.battery.voltage_v) / kStep};
              };
              out.push_back(one);
            }
            return out;
          },
          .seeming = [](const Form& form, const Recording& log, double deviation_a) {
            return form.channel == "current" ? seeming_delay_s(log, deviation_a) : 0.0;
          }};
}

}  // namespace voltlap::plant
