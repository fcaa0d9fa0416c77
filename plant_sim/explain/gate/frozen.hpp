// SPDX-License-Identifier: Apache-2.0
// Sensors that say one value on and on: their readings are masked there, and said.
#pragma once
#include <string>
#include <vector>

#include "explain/gate/integrity.hpp"

namespace voltlap::plant {

/// One channel of a log.
struct Sensor {
  const std::string& role;
  Eigen::VectorXd& values;
  const char* unit;
};

/// What moves while a frozen value stands still, and by how much at least.
struct Neighbour {
  const Eigen::VectorXd& moving;
  double moved_by;
};

/// Makes rows NaN, with the reason.
void mask(Recording& log, const Sensor& sensor, Eigen::Index first, Eigen::Index last, const std::string& why);

/// A value that stands while its neighbour moves.
void mask_frozen(Recording& log, const Sensor& sensor, const Neighbour& neighbour,
                 std::vector<GateFinding>& findings);

/// The noise of a sensor moves it by a step or so all the time. A value that then stands four times as long as any
/// other in the log is frozen. One whose steps are coarser than its noise, or that has none, stands for long
/// wherever it is: nobody can tell.
void mask_standing(Recording& log, const Sensor& sensor, std::vector<GateFinding>& findings);

}  // namespace voltlap::plant
