// SPDX-License-Identifier: Apache-2.0
#include "explain/model/settled_temperature.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "explain/model/unstepped.hpp"

namespace voltlap::explain {
namespace {

constexpr double kSlow_s = 100.0;  // on each side, over which thermistors are believed

/// Straight where nothing is known; the ends hold.
VectorXd bridged(const VectorXd& time_s, VectorXd values) {
  Index before = -1;
  for (Index row = 0; row < values.size(); ++row) {
    if (!std::isfinite(values(row))) continue;
    for (Index gap = before + 1; gap < row; ++gap) {
      const double part = before < 0 ? 1.0 : (time_s(gap) - time_s(before)) / (time_s(row) - time_s(before));
      values(gap) = before < 0 ? values(row) : values(before) + part * (values(row) - values(before));
    }
    before = row;
  }
  for (Index row = before + 1; before >= 0 && row < values.size(); ++row) values(row) = values(before);
  return values;
}

}  // namespace

VectorXd without_steps(const plant::Recording& log) {
  const plant::Recording read = unstepped(log, Passes::kAny);
  constexpr double kMuch = 0.2;  // of the rows
  const std::vector<std::string> roles = log.numbered("temperature_");
  VectorXd out = VectorXd::Zero(log.rows());
  bool same = true;
  for (const std::string& role : roles) {
    const VectorXd &fine = *read.find(role), &coarse = *log.find(role);
    same = same && (fine.array() == coarse.array() || coarse.array().isNaN()).all();
    out += fine / static_cast<double>(roles.size());
  }
  const auto known = static_cast<double>(out.array().isFinite().count());
  return same || known < kMuch * static_cast<double>(out.size()) ? VectorXd() : out;
}

void settle_temperature(const plant::World& model, const Observed& log, plant::LogFacts& facts) {
  if (log.thermistors_c.size() == 0) return;
  facts.temperature_c = log.thermistors_c;
  const VectorXd surface = plant::battery_response(model, log.comparison.log, facts).surface_c;
  const VectorXd& time_s = log.comparison.log.time_s;
  const bool fine = log.fine_c.size() > 0;
  const VectorXd beside = bridged(time_s, (fine ? log.fine_c : log.read_c) - surface);
  facts.temperature_c = surface + plant::smoothed(time_s, beside, kSlow_s);
  facts.thermistor_c = fine ? facts.temperature_c : log.thermistors_c;  // how fast it changes no step tells
  plant::settle_above_surface(model, log.comparison.log, facts);
}

plant::LogFacts facts_with(const plant::World& world, const Observed& log) {
  plant::LogFacts out = log.comparison.facts;
  settle_temperature(world, log, out);
  return out;
}

}  // namespace voltlap::explain
