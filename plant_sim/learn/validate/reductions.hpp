// SPDX-License-Identifier: Apache-2.0
// Tables without one of their dependences, and what that costs in prediction (reference study, 2016, sections 7.2.2
// and 7.3.1): a parameter that may do without current or temperature makes the model smaller.
#pragma once
#include <string>
#include <vector>

#include "learn/validate/table_parameter.hpp"
#include "learn/validate/prediction_error.hpp"

namespace voltlap::plant {

/// The cell with the mean over the axis in the place of each value along it.
[[nodiscard]] CellParameters without_dependence(const CellParameters& cell, TableParameter parameter,
                                                TableAxis axis);

struct Reduction {
  std::vector<TableParameter> parameters;  ///< that lose the dependence; empty: the whole model
  TableAxis axis = TableAxis::kCurrent;
  double rms_v = 0.0;
};

/// The whole model first, then each parameter without current and without temperature, and Em with R0 without
/// current as the study reduced them. Only dependences that the file has; over all recordings together.
[[nodiscard]] std::vector<Reduction> reductions(const CellParameters& cell,
                                                const std::vector<PlacedRecording>& recordings);

}  // namespace voltlap::plant
