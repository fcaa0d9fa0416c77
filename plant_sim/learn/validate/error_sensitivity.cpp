// SPDX-License-Identifier: Apache-2.0
#include "learn/validate/error_sensitivity.hpp"

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
  const char* parameter;
  void (*change)(CellParameters&, double factor);  ///< of the tables; none: of the run
};
constexpr std::array kRows{
    Row{"em", scale_em},
    Row{"r0", [](CellParameters& c, double f) { scale(c.r0_ohm, f); }},
    Row{"r1", [](CellParameters& c, double f) { scale(c.r1_ohm, f), scale(c.tau1_s, f); }},
    Row{"r2", [](CellParameters& c, double f) { scale(c.r2_ohm, f), scale(c.tau2_s, f); }},
    Row{"c1", [](CellParameters& c, double f) { scale(c.tau1_s, f); }},
    Row{"c2", [](CellParameters& c, double f) { scale(c.tau2_s, f); }},
    Row{"initial_soc", nullptr},
    Row{"capacity", nullptr},
};

}  // namespace

std::vector<ErrorSensitivity> error_sensitivities(const CellParameters& cell,
                                                  const std::vector<PlacedRecording>& recordings,
                                                  const std::vector<CapacityAdjustment>& capacities) {
  VOLTLAP_DEMAND(!recordings.empty() && capacities.size() == recordings.size());
  std::vector<ErrorSensitivity> out;
  for (const Row& row : kRows) {
    const std::string name = row.parameter;
    ErrorSensitivity one{name, {}};
    for (std::size_t step = 0; step < kSensitivitySteps.size(); ++step) {
      const double by = kSensitivitySteps[step];
      CellParameters changed = cell;
      if (row.change != nullptr) row.change(changed, 1.0 + by);
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
