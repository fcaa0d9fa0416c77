// SPDX-License-Identifier: Apache-2.0
#include "learn/validate/error_sensitivity.hpp"

#include <fmt/format.h>

#include <functional>

#include "core/demand.hpp"

namespace voltlap::plant {
namespace {

void scale(std::vector<double>& values, double factor) {
  for (double& value : values) value *= factor;
}
void scale(CellParameterMap& map, double factor) {
  scale(map.value, factor);
  scale(map.table, factor);
}
void scale_em(CellParameters& cell, double factor) {
  for (auto* values : {&cell.ocv_v, &cell.ocv_polynomial_v, &cell.ocv_table_v}) scale(*values, factor);
}

struct Row {
  std::string parameter;
  std::function<void(CellParameters&, double factor)> change;  ///< of the tables; none: of the run
};

std::vector<Row> rows_of(const CellParameters& cell) {
  std::vector<Row> out{{"em", scale_em}, {"r0", [](CellParameters& c, double f) { scale(c.r0_ohm, f); }}};
  for (std::size_t k = 0; k < cell.branch_count(); ++k) {
    out.push_back({fmt::format("r{}", k + 1), [k](CellParameters& c, double f) {
                     scale(c.branches[k].r_ohm, f);
                     scale(c.branches[k].tau_s, f);
                   }});
  }
  for (std::size_t k = 0; k < cell.branch_count(); ++k) {
    out.push_back({fmt::format("c{}", k + 1), [k](CellParameters& c, double f) { scale(c.branches[k].tau_s, f); }});
  }
  out.push_back({"initial_soc", nullptr});
  out.push_back({"capacity", nullptr});
  return out;
}

}  // namespace

std::vector<ErrorSensitivity> error_sensitivities(const CellParameters& cell,
                                                  const std::vector<PlacedRecording>& recordings,
                                                  const std::vector<CapacityAdjustment>& capacities) {
  VOLTLAP_DEMAND(!recordings.empty() && capacities.size() == recordings.size());
  std::vector<ErrorSensitivity> out;
  for (const Row& row : rows_of(cell)) {
    const std::string& name = row.parameter;
    ErrorSensitivity one{name, {}};
    for (std::size_t step = 0; step < kSensitivitySteps.size(); ++step) {
      const double by = kSensitivitySteps[step];
      CellParameters changed = cell;
      if (row.change) row.change(changed, 1.0 + by);
      const CellModel model(changed);
      ErrorSum sum;
      for (std::size_t k = 0; k < recordings.size(); ++k) {
        const double capacity = recordings[k].options.capacity_ah + capacities[k].by_ah;
        sum += error_of(model, recordings[k],
                        {name == "capacity" ? capacity * (1.0 + by) : capacity, name == "initial_soc" ? by : 0.0});
      }
      one.rms_v[step] = sum.rms_v();
    }
    out.push_back(one);
  }
  return out;
}

}  // namespace voltlap::plant
