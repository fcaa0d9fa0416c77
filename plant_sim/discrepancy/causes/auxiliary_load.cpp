// SPDX-License-Identifier: Apache-2.0
// Something draws power all the time, at standstill too.
#include <cmath>

#include "discrepancy/cause.hpp"
#include "discrepancy/causes/list.hpp"

namespace voltlap::plant {
namespace {

double mean_voltage(const Recording& log) {
  for (const char* role : {"pack_voltage", "bus_voltage", "voltage"}) {
    const Eigen::VectorXd* volts = log.find(role);
    if (volts == nullptr) continue;
    double sum = 0.0, rows = 0.0;
    for (const double v : *volts) {
      if (std::isfinite(v)) sum += v, rows += 1.0;
    }
    if (rows > 0.0) return sum / rows;
  }
  return 0.0;
}

}  // namespace

Cause auxiliary_load() {
  return {.name = "auxiliary_load",
          .balance = Balance::kPower,
          .says = "something draws {} more all the time",
          .test = "a minute of standing with the tractive system on",
          .parameters =
              {{"power_w", "W", -2000, 5000, 150, 1, "W", 8}},
          .forms = [](const World&, const Comparison& c) -> std::vector<Form> {
            if (c.find("power") == nullptr) return {};
            return {plain_form(1, [](World& w, Values v) { w.car.low_voltage.power_w += v[0]; })};
          },
          // A reading stays on one side of its step at standstill too.
          .seeming = [](const Form&, const Recording& log, double deviation_a) { return deviation_a * mean_voltage(log); }};
}

}  // namespace voltlap::plant
