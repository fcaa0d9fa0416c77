// SPDX-License-Identifier: Apache-2.0
// One cell has more resistance or less capacity than the others (or its tap a bad contact: one class).
#include "explain/causes/cause.hpp"
#include "explain/causes/list.hpp"

namespace voltlap::plant {

Cause weak_cell() {
  return {.name = "weak_cell",
          .balance = Balance::kVoltage,
          .says = "{channel} differs from the others: resistance {}, capacity {}",
          .test = "a pulse of a minute at half SOC and a rest at the low end, all cells read",
          .parameters = {{"resistance_change", "1", -0.6, 5, 0.1, 100, "%"},
                         {"capacity_change", "1", -0.6, 0.6, 0.05, 100, "%"}},
          .forms = [](const World&, const Comparison&) -> std::vector<Form> {
            const auto resistance = [](const World&, const Comparison&, const Prediction& p) {
              return Eigen::VectorXd(-p.battery.drop_v);
            };
            const auto capacity = [](const World& world, const Comparison& on, const Prediction& p) {
              Eigen::VectorXd drawn = Eigen::VectorXd::Zero(on.log.rows());
              for (Eigen::Index row = 1; row < on.log.rows(); ++row) {
                const double dt = on.log.time_s(row) - on.log.time_s(row - 1);
                drawn(row) =
                    drawn(row - 1) + 0.5 * (p.battery.current_a(row) + p.battery.current_a(row - 1)) * dt / 3600.0;
              }
              return Eigen::VectorXd(drawn.cwiseProduct(p.battery.ocv_slope_v) / world.car.cell.capacity_ah);
            };
            Form form;
            form.stem = "cell_voltage_";
            form.at = {0.0, 0.0};
            // A cell of half the capacity runs down a steeper part of its curve.
            form.curved = [=](const World& world, const Comparison& on, const Prediction& p, Values v) {
              World weak = world;
              weak.car.cell.capacity_ah *= 1.0 + v[1];
              const Eigen::VectorXd by_capacity =
                  v[1] == 0.0
                      ? Eigen::VectorXd(Eigen::VectorXd::Zero(on.log.rows()))
                      : Eigen::VectorXd(battery_response(weak, on.log, on.facts).voltage_v - p.battery.voltage_v);
              return Eigen::VectorXd(by_capacity + v[0] * resistance(world, on, p));
            };
            std::vector<Form> out;
            form.linear = form.refined = {0};
            form.shapes = [=](const World& m, const Comparison& on, const Prediction& p) {
              return std::vector<Eigen::VectorXd>{resistance(m, on, p)};
            };
            out.push_back(form);
            form.linear = form.refined = {1};
            form.shapes = [=](const World& m, const Comparison& on, const Prediction& p) {
              return std::vector<Eigen::VectorXd>{capacity(m, on, p)};
            };
            out.push_back(form);
            form.linear = form.refined = {0, 1};
            form.shapes = [=](const World& m, const Comparison& on, const Prediction& p) {
              return std::vector<Eigen::VectorXd>{resistance(m, on, p), capacity(m, on, p)};
            };
            out.push_back(form);
            return out;
          },
          .extend =
              [](VehicleParameters& car, std::size_t cell, Values v) {
                CellVariation& variation = cell_variation(car, cell);
                variation.resistance_scale *= 1.0 + v[0];
                variation.capacity_scale *= 1.0 + v[1];
              }};
}

}  // namespace voltlap::plant
