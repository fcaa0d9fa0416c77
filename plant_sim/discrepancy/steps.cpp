// SPDX-License-Identifier: Apache-2.0
#include "discrepancy/steps.hpp"

#include <cmath>
#include <string_view>

namespace voltlap::plant {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// Delay that noise of the readings seems to be: a difference of readings holds it as the error behind them does.
double seeming_delay_s(const Recording& log, double deviation_a) {
  const VectorXd& current = *log.find("current");
  double square = 0.0, rows = 0.0;
  for (Index k = 1; k < current.size(); ++k) {
    const double step = current(k) - current(k - 1);
    if (!std::isfinite(step)) continue;
    square += step * step;
    rows += 1.0;
  }
  const double row_s = (log.time_s(log.time_s.size() - 1) - log.time_s(0)) / static_cast<double>(log.time_s.size() - 1);
  return square > 0.0 ? row_s * deviation_a * deviation_a * rows / square : 0.0;
}

double mean_voltage(const Recording& log) {
  for (const char* role : {"pack_voltage", "bus_voltage", "voltage"}) {
    const VectorXd* volts = log.find(role);
    if (volts == nullptr) continue;
    double sum = 0.0, rows = 0.0;
    for (const double v : *volts) {
      if (std::isfinite(v)) sum += v, rows += 1.0;
    }
    if (rows > 0.0) return sum / rows;
  }
  return 0.0;
}

}  // namespace

void allow_for_steps(double deviation_a, const std::vector<Cause>& causes, Design& design, NoiseModel& noise) {
  if (!(deviation_a > 0.0)) return;
  const Recording& log = design.comparison.log;
  double& of_current = noise[design.comparison.channels.front().name].current_a;
  of_current = std::hypot(of_current, deviation_a);
  for (Column& column : design.columns) {
    if (column.cause < 0) continue;
    const Cause& cause = causes[static_cast<std::size_t>(column.cause)];
    const std::string_view name = cause.name;
    double size = 0.0;
    if (name == "current_offset") size = deviation_a;
    if (name == "auxiliary_load") size = deviation_a * mean_voltage(log);
    const Form& form = design.forms[static_cast<std::size_t>(column.cause)][column.form];
    if (name == "time_skew" && form.channel == "current") size = seeming_delay_s(log, deviation_a);
    column.repeats = std::hypot(column.repeats, size / cause.parameters[column.parameter].typical);
  }
}

}  // namespace voltlap::plant
