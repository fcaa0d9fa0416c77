// SPDX-License-Identifier: Apache-2.0
#include "learn/validate/reductions.hpp"

#include <algorithm>

#include "core/demand.hpp"

namespace voltlap::plant {
namespace {

bool depends_on(const CellParameters& cell, TableParameter parameter, TableAxis axis) {
  return table_of(cell, parameter) != table_of(without_dependence(cell, parameter, axis), parameter);
}

Reduction reduced(const CellParameters& cell, const std::vector<PlacedRecording>& recordings,
                  std::vector<TableParameter> parameters, TableAxis axis) {
  CellParameters small = cell;
  for (const TableParameter parameter : parameters) small = without_dependence(small, parameter, axis);
  const CellModel model(small, OcvOf::kSocTemperatureCurrent);
  ErrorSum sum;
  for (const PlacedRecording& recording : recordings) sum += error_of(model, recording);
  return {std::move(parameters), axis, sum.rms_v()};
}

}  // namespace

CellParameters without_dependence(const CellParameters& cell, TableParameter parameter, TableAxis axis) {
  std::vector<double> table = table_of(cell, parameter);
  if (table.empty()) return cell;
  const std::size_t currents = cell.current_breakpoints_a.size(),
                    temperatures = cell.temperature_breakpoints_c.size();
  const bool by_current = axis == TableAxis::kCurrent;
  VOLTLAP_DEMAND(table.size() == cell.soc_breakpoints.size() * temperatures * currents);
  const std::size_t points = by_current ? currents : temperatures, stride = by_current ? 1 : currents,
                    others = by_current ? temperatures : currents, step = by_current ? currents : 1;
  for (std::size_t soc = 0; soc < cell.soc_breakpoints.size(); ++soc) {
    for (std::size_t other = 0; other < others; ++other) {
      double* line = &table[soc * temperatures * currents + other * step];
      const auto [low, high] = [&] {
        double least = line[0], most = line[0];
        for (std::size_t k = 1; k < points; ++k) {
          least = std::min(least, line[k * stride]);
          most = std::max(most, line[k * stride]);
        }
        return std::pair{least, most};
      }();
      if (low == high) continue;  // the mean of equal numbers is not always that number
      double mean = 0.0;
      for (std::size_t k = 0; k < points; ++k) mean += line[k * stride] / static_cast<double>(points);
      for (std::size_t k = 0; k < points; ++k) line[k * stride] = mean;
    }
  }
  CellParameters out = cell;
  set_table(out, parameter, std::move(table));
  return out;
}

std::vector<Reduction> reductions(const CellParameters& cell, const std::vector<PlacedRecording>& recordings) {
  VOLTLAP_DEMAND(!recordings.empty());
  std::vector<Reduction> out{reduced(cell, recordings, {}, TableAxis::kCurrent)};
  for (const TableAxis axis : {TableAxis::kCurrent, TableAxis::kTemperature}) {
    std::vector<TableParameter> there;
    for (const TableParameter parameter : table_parameters(cell)) {
      if (!depends_on(cell, parameter, axis)) continue;
      there.push_back(parameter);
      out.push_back(reduced(cell, recordings, {parameter}, axis));
    }
    const auto has = [&](TableParameter p) { return std::find(there.begin(), there.end(), p) != there.end(); };
    if (axis == TableAxis::kCurrent && has(TableParameter::kEm) && has(TableParameter::kR0))
      out.push_back(reduced(cell, recordings, {TableParameter::kEm, TableParameter::kR0}, axis));
    if (there.size() > 1) out.push_back(reduced(cell, recordings, there, axis));
  }
  return out;
}

}  // namespace voltlap::plant
