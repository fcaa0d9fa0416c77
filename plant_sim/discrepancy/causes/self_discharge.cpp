// SPDX-License-Identifier: Apache-2.0
// One cell loses charge by itself: self-discharge or a soft short. Grows with time, at rest too.
#include "discrepancy/cause.hpp"
#include "discrepancy/causes/list.hpp"

namespace voltlap::plant {

Cause self_discharge() {
  return {.name = "self_discharge",
          .balance = Balance::kCharge,
          .says = "{channel} loses {} all the time, at rest too",
          .test = "a rest of an hour, all cells read at both ends",
          .parameters =
              // Spread as sound logs of the bank want it; nearly the shape of a capacity (weak_cell.cpp).
              {{"current_a", "A", 0, 5, 0.05, 1e3, "mA", 5e-4, 0.07}},
          .forms = [](const World&, const Comparison&) -> std::vector<Form> {
            Form form;
            form.stem = "cell_voltage_";
            form.at = {0.0};
            form.linear = form.refined = {0};
            form.shapes = [](const World& world, const Comparison& on, const Prediction& p) -> std::vector<Eigen::VectorXd> {
              const Eigen::VectorXd hours = (on.log.time_s.array() - on.log.time_s(0)) / 3600.0;
              return {-(hours.array() * p.battery.ocv_slope_v.array() / world.car.cell.capacity_ah).matrix()};
            };
            return {form};
          },
          .extend = [](VehicleParameters& car, std::size_t cell, Values v) { cell_variation(car, cell).leak_a += v[0]; }};
}

}  // namespace voltlap::plant
