// SPDX-License-Identifier: Apache-2.0
// Cells warm their neighbours: those inside the row lose less of their heat to the air than the two at its ends.
// Signature: the end thermistors fall behind by a share of the rise.
#include "explain/causes/cause.hpp"
#include "explain/causes/list.hpp"

namespace voltlap::plant {

Cause neighbour_heat() {
  return {.name = "neighbour_heat",
          .balance = Balance::kHeat,
          .says = "cells keep {} of their rise above the row's ends by their neighbours",
          .test = "thermistors at the ends and the middle over a hard stretch and a stop",
          .parameters = {{"fraction", "1", -0.5, 0.9, 0.1, 100, "%"}},
          .forms = [](const World&, const Comparison& c) -> std::vector<Form> {
            if (c.log.numbered("temperature_").size() < 3) return {};
            Form form;
            form.stem = "temperature_";
            form.channel = "ends";
            form.at = {0.0};
            form.linear = form.refined = {0};
            form.shapes = [](const World&, const Comparison&, const Prediction& p) -> std::vector<Eigen::VectorXd> {
              return {-(p.battery.temperature_c.array() - p.battery.temperature_c(0)).matrix()};
            };
            return {form};
          }};
}

}  // namespace voltlap::plant
