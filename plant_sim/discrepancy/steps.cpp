// SPDX-License-Identifier: Apache-2.0
#include "discrepancy/steps.hpp"

#include <cmath>

namespace voltlap::plant {
void allow_for_steps(double deviation_a, const std::vector<Cause>& causes, Design& design, NoiseModel& noise) {
  if (!(deviation_a > 0.0)) return;
  const Recording& log = design.comparison.log;
  double& of_current = noise[design.comparison.channels.front().name].current_a;
  of_current = std::hypot(of_current, deviation_a);
  for (Column& column : design.columns) {
    if (column.cause < 0) continue;
    const Cause& cause = causes[static_cast<std::size_t>(column.cause)];
    if (!cause.seeming) continue;
    const Form& form = design.forms[static_cast<std::size_t>(column.cause)][column.form];
    const double size = cause.seeming(form, log, deviation_a);
    column.repeats = std::hypot(column.repeats, size / cause.parameters[column.parameter].typical);
  }
}

}  // namespace voltlap::plant
