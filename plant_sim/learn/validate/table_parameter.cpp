// SPDX-License-Identifier: Apache-2.0
#include "learn/validate/table_parameter.hpp"

#include "car/battery/cell_tables.hpp"
#include "core/demand.hpp"

namespace voltlap::plant {

namespace {

constexpr auto kFirstR = static_cast<std::size_t>(TableParameter::kR1);
constexpr auto kFirstTau = static_cast<std::size_t>(TableParameter::kTau1);
static_assert(kFirstTau - kFirstR == kMostCellBranches);

double value_of(const CircuitParameters& p, TableParameter parameter) {
  const auto index = static_cast<std::size_t>(parameter);
  if (parameter == TableParameter::kR0) return p.r0_ohm;
  return index < kFirstTau ? p.r_ohm[index - kFirstR] : p.tau_s[index - kFirstTau];
}

CellParameterMap& map_of(CellParameters& cell, TableParameter parameter) {
  const auto index = static_cast<std::size_t>(parameter);
  if (parameter == TableParameter::kR0) return cell.r0_ohm;
  return index < kFirstTau ? cell.branches[index - kFirstR].r_ohm : cell.branches[index - kFirstTau].tau_s;
}

}  // namespace

std::vector<TableParameter> table_parameters(const CellParameters& cell) {
  std::vector<TableParameter> out{TableParameter::kEm, TableParameter::kR0};
  for (const std::size_t first : {kFirstR, kFirstTau}) {
    for (std::size_t k = 0; k < cell.branch_count(); ++k) out.push_back(static_cast<TableParameter>(first + k));
  }
  return out;
}

std::vector<double> table_of(const CellParameters& cell, TableParameter parameter) {
  if (parameter == TableParameter::kEm) return cell.ocv_table_v;
  const CellTables tables(cell);
  std::vector<double> out;
  for (const double soc : cell.soc_breakpoints) {
    for (const double temperature : cell.temperature_breakpoints_c) {
      for (const double current : cell.current_breakpoints_a) {
        out.push_back(value_of(tables.circuit(soc, temperature, current), parameter));
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
  map_of(cell, parameter) = {{}, 0.0, 0.0, std::move(table)};
}

}  // namespace voltlap::plant
