// SPDX-License-Identifier: Apache-2.0
// One cell loses charge by itself: self-discharge or a soft short. Grows with time, at rest too.
#include "car/battery/cell_tables.hpp"
#include "explain/causes/cause.hpp"
#include "explain/causes/list.hpp"

namespace voltlap::plant {

Cause self_discharge() {
  return {.name = "self_discharge",
          .balance = Balance::kCharge,
          .says = "{channel} loses {} all the time, at rest too",
          .test = "a rest of an hour, all cells read at both ends",
          .parameters = {{"current_a", "A", 0, 20, 0.05, 1e3, "mA"}},
          .forms = [](const World&, const Comparison&) -> std::vector<Form> {
            Form form;
            form.stem = "cell_voltage_";
            form.at = {0.0};
            form.linear = form.refined = {0};
            form.shapes = [](const World& world, const Comparison& on,
                             const Prediction& p) -> std::vector<Eigen::VectorXd> {
              const Eigen::VectorXd hours = (on.log.time_s.array() - on.log.time_s(0)) / 3600.0;
              return {-(hours.array() * p.battery.ocv_slope_v.array() / world.car.cell.capacity_ah).matrix()};
            };
            // A cell that has lost much runs down another part of its curve than the others.
            form.curved = [](const World& world, const Comparison& on, const Prediction& p, Values v) {
              const CellTables tables(world.car.cell);
              const BatteryResponse& b = p.battery;
              Eigen::VectorXd out(on.log.rows());
              for (Eigen::Index row = 0; row < out.size(); ++row) {
                const double hours = (on.log.time_s(row) - on.log.time_s(0)) / 3600.0;
                const double soc = b.soc(row) - v[0] * hours / world.car.cell.capacity_ah,
                             at_c = b.temperature_c(row);
                const double ohm = tables.circuit(soc, at_c, b.current_a(row)).r0_ohm;
                const double before = tables.circuit(b.soc(row), at_c, b.current_a(row)).r0_ohm;
                out(row) =
                    tables.ocv_v(soc, at_c) - tables.ocv_v(b.soc(row), at_c) - b.drop_v(row) * (ohm / before - 1.0);
              }
              return out;
            };
            return {form};
          },
          .extend = [](VehicleParameters& car, std::size_t cell,
                       Values v) { cell_variation(car, cell).leak_a += v[0]; }};
}

}  // namespace voltlap::plant
