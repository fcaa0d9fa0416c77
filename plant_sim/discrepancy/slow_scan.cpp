// SPDX-License-Identifier: Apache-2.0
#include "discrepancy/slow_scan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "discrepancy/balances.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

bool is_cell(const std::string& role) { return role.starts_with("cell_voltage_"); }

/// V(t) - V(t - age), straight between rows.
VectorXd change_since(const VectorXd& time, const VectorXd& voltage, const VectorXd& age_s) {
  VectorXd out(time.size());
  Index before = 0;
  for (Index row = 0; row < time.size(); ++row) {
    const double then = std::max(time(0), time(row) - age_s(row));
    while (before > 0 && time(before) > then) --before;
    while (before + 1 < row && time(before + 1) <= then) ++before;
    const double span = row > before ? time(std::min(before + 1, row)) - time(before) : 0.0;
    const double share = span > 0.0 ? std::clamp((then - time(before)) / span, 0.0, 1.0) : 0.0;
    const double past = voltage(before) + share * (voltage(std::min(before + 1, row)) - voltage(before));
    out(row) = voltage(row) - past;
  }
  return out;
}

}  // namespace

void bring_to_rows(Recording& log, const Model& model) {
  const auto due = [](const auto& entry) { return is_cell(entry.first) || entry.first == "pack_voltage"; };
  if (!std::any_of(log.age_s.begin(), log.age_s.end(), due)) return;
  const Comparison c = comparison_of(model.world, log, {.soc_stated = model.kind != ModelKind::kCell});
  const VectorXd voltage = predict(model.world, c).battery.voltage_v;
  double oldest = 0.0;
  for (const auto& [role, age] : log.age_s) {
    if (!is_cell(role) && role != "pack_voltage") continue;
    const double cells = is_cell(role) ? 1.0 : model.world.car.battery.cells_in_series;
    log.signals[role] += cells * change_since(log.time_s, voltage, age);
    if (is_cell(role)) oldest = std::max(oldest, age.mean());
  }
  if (oldest > 0.0) {
    log.repairs.push_back(fmt::format("the cells are read in turn, on average up to {:.2g} s before the current: each is "
                                      "compared at its own time", oldest));
  }
}

}  // namespace voltlap::plant
