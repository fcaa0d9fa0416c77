// SPDX-License-Identifier: Apache-2.0
// What a refined set of causes does to every channel of a log: the model with it minus the model without, in the
// channel's unit.
#pragma once
#include <Eigen/Dense>
#include <vector>

#include "discrepancy/judged.hpp"

namespace voltlap::plant {

struct Effects {
  std::vector<Eigen::VectorXd> channels;
  std::vector<std::vector<Eigen::VectorXd>> members;  ///< [group][member]
};

[[nodiscard]] Effects effects_of(const Judged& judged, const std::vector<RefinedCause>& causes);

/// By the linear signatures alone, of candidates with or without a name; `sizes`: of all their rows, in typical sizes.
[[nodiscard]] Effects linear_effects(const Judged& judged, const std::vector<std::size_t>& members,
                                     const Eigen::VectorXd& sizes);

/// On another log of the same battery or car: what a cell or sensor has it keeps, where a log began it does not.
[[nodiscard]] Effects effects_on(const Judged& judged, const std::vector<RefinedCause>& causes,
                                 const Comparison& other);

}  // namespace voltlap::plant
