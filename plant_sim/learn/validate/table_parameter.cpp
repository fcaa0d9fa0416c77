// SPDX-License-Identifier: Apache-2.0
#include "learn/validate/table_parameter.hpp"

#include "car/battery/cell_tables.hpp"
#include "core/demand.hpp"

namespace voltlap::plant {

std::vector<double> table_of(const CellParameters& cell, TableParameter parameter) {
  if (parameter == TableParameter::kEm) return cell.ocv_table_v;
  const CellTables tables(cell);
  std::vector<double> out;
  for (const double soc : cell.soc_breakpoints) {
    for (const double temperature : cell.temperature_breakpoints_c) {
      for (const double current : cell.current_breakpoints_a) {
        const CircuitParameters p = tables.circuit(soc, temperature, current);
        const std::array values{0.0, p.r0_ohm, p.r1_ohm, p.r2_ohm, p.tau1_s, p.tau2_s};
        out.push_back(values[static_cast<std::size_t>(parameter)]);
      }
    }
  }
  return out;
}

void set_table(CellParameters& cell, TableParameter parameter, std::vector<double> table) {
  VOLTLAP_DEMAND(table.size() == cell.soc_breakpoints.size() * cell.temperature_breakpoints_c.size() *
                                     cell.current_breakpoints_a.size());
  if (parameter == TableParameter::kEm) {
    cell.ocv_table_v = std::move(table);
    return;
  }
  const std::array maps{&cell.r0_ohm, &cell.r1_ohm, &cell.r2_ohm, &cell.tau1_s, &cell.tau2_s};
  *maps[static_cast<std::size_t>(parameter) - 1] = {{}, 0.0, 0.0, std::move(table)};
}

}  // namespace voltlap::plant
