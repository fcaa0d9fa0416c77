// SPDX-License-Identifier: Apache-2.0
// How much the tables of a cell file change along an axis (reference study, 2016, Eq. 7.1 and 7.5,
// Tables 7.1, 7.2):
//
//   dx/dI = mean over SOC and T of  100 / x_mean(SOC, T) * 1/(n-1) sum_k (x_{k+1} - x_k) / (I_{k+1} - I_k)    [%/A]
//   dx/dT likewise along temperature, over SOC and I                                                          [%/K]
//
// n breakpoints along the axis; x_mean is the mean of the n values.
#pragma once
#include <optional>
#include <vector>

#include "learn/validate/table_parameter.hpp"

namespace voltlap::plant {

struct TableSensitivity {
  TableParameter parameter;
  std::optional<double> pct_per_ampere,
      pct_per_kelvin;  ///< empty: the file does not tell, see `table_sensitivities`
};

/// Empty where the axis has one breakpoint, and for Em where the file has no `ocv.table`.
[[nodiscard]] std::vector<TableSensitivity> table_sensitivities(const CellParameters& cell);

}  // namespace voltlap::plant
