// SPDX-License-Identifier: Apache-2.0
// A recording without what was found in single members, so that the rest is judged as if they were sound: their
// mean, the heat, the pack voltage beside them.
#pragma once
#include "explain/causes/cause.hpp"
#include "explain/model/observed.hpp"

namespace voltlap::explain {

/// What a member's readings have too much, by row.
struct MemberEffect {
  std::string role;
  bool of_sensor = false;  ///< then the pack voltage does not have it
  VectorXd by_row;
};
[[nodiscard]] plant::Recording corrected(plant::Recording log, const std::vector<MemberEffect>& effects);

}  // namespace voltlap::explain
