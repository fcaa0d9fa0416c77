// SPDX-License-Identifier: Apache-2.0
// A current sensor that ends at a limit. Its readings pile up there, as those of a battery do that is held at a
// limit; but the voltage sags beyond what they give, and the rest of the log agrees with the current that it asks
// for.
#pragma once
#include <Eigen/Dense>
#include <optional>
#include <string>
#include <vector>

#include "explain/balances/recording.hpp"

namespace voltlap::plant {

/// The pile of readings at the end of a current.
struct Rail {
  double limit_a = 0.0, noise_a = 0.0;  ///< mean and standard deviation of its readings
  double from_a = 0.0;                  ///< no reading of the limit is less
  double step_a = 0.0;                  ///< of the log's readings; 0: they have none
  std::vector<bool> at;                 ///< rows that read it
};
/// Where other rows have large currents, too: what a model makes of those has to be known.
[[nodiscard]] std::optional<Rail> rail_of(const Eigen::VectorXd& current_a);

void mask_rail(const Rail& rail, const Recording& log, std::vector<Masked>& masked);

}  // namespace voltlap::plant
