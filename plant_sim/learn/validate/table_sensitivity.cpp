// SPDX-License-Identifier: Apache-2.0
#include "learn/validate/table_sensitivity.hpp"

#include "core/demand.hpp"

namespace voltlap::plant {
namespace {

/// Along a line of n values that lie `stride` apart, in percent of their mean.
double slope_of_line(const double* x, std::size_t stride, const std::vector<double>& axis) {
  double slopes = 0.0, mean = 0.0;
  for (std::size_t k = 0; k < axis.size(); ++k) {
    mean += x[k * stride] / static_cast<double>(axis.size());
    if (k > 0) slopes += (x[k * stride] - x[(k - 1) * stride]) / (axis[k] - axis[k - 1]);
  }
  return 100.0 * slopes / static_cast<double>(axis.size() - 1) / mean;
}

std::optional<double> mean_slope(const CellParameters& cell, const std::vector<double>& table, TableAxis axis) {
  const std::size_t currents = cell.current_breakpoints_a.size(),
                    temperatures = cell.temperature_breakpoints_c.size();
  const bool by_current = axis == TableAxis::kCurrent;
  const std::vector<double>& at = by_current ? cell.current_breakpoints_a : cell.temperature_breakpoints_c;
  if (table.empty() || at.size() < 2) return std::nullopt;
  VOLTLAP_DEMAND(increasing(at) && table.size() == cell.soc_breakpoints.size() * temperatures * currents);
  const std::size_t stride = by_current ? 1 : currents, others = by_current ? temperatures : currents,
                    step = by_current ? currents : 1;
  double sum = 0.0;
  for (std::size_t soc = 0; soc < cell.soc_breakpoints.size(); ++soc) {
    for (std::size_t other = 0; other < others; ++other)
      sum += slope_of_line(&table[soc * temperatures * currents + other * step], stride, at);
  }
  return sum / static_cast<double>(cell.soc_breakpoints.size() * others);
}

}  // namespace

std::vector<TableSensitivity> table_sensitivities(const CellParameters& cell) {
  std::vector<TableSensitivity> out;
  for (const TableParameter parameter : table_parameters(cell)) {
    const std::vector<double> table = table_of(cell, parameter);
    out.push_back({parameter, mean_slope(cell, table, TableAxis::kCurrent),
                   mean_slope(cell, table, TableAxis::kTemperature)});
  }
  return out;
}

}  // namespace voltlap::plant
