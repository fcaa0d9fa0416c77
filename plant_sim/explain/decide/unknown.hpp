// SPDX-License-Identifier: Apache-2.0
// Is something wrong that no cause describes? A flexible smooth model (shapes over SOC, current at several lags,
// temperature and time; explain/shapes/anonymous_shapes.hpp) is fitted beside the answer and judged like any
// hypothesis.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "explain/decide/answer.hpp"

namespace voltlap::explain {

/// What smooth shapes take from a channel beyond a set of causes.
struct Unnamed {
  std::string channel;
  plant::Balance balance = plant::Balance::kVoltage;
  double practical = 0.0;  ///< RMS over what is worth a word
  Lead lead;
};
/// By channel that has shapes and whose residual beyond the answer, `left`, is as large as `least` practical sizes.
[[nodiscard]] std::vector<Unnamed> unnamed_in(const Observed& log, const std::vector<VectorXd>& left, double least);

}  // namespace voltlap::explain
