// SPDX-License-Identifier: Apache-2.0
#include "learn/validate/cell_response.hpp"

#include <algorithm>
#include <cmath>

#include "car/battery/cell_effects.hpp"
#include "core/errors.hpp"
#include "learn/identify/circuit_model.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;

constexpr double kLookupShare = 0.005;  // of the largest current: smaller ones keep the last lookup current

/// The cell with its open-circuit voltages in the place of R0.
CellParameters with_ocv_as_r0(CellParameters cell) {
  cell.r0_ohm = {{}, 0.0, 0.0, cell.ocv_table_v};
  return cell;
}

double at_row(const std::vector<double>& values, Index row, double otherwise) {
  if (values.empty()) return otherwise;
  const double value = values[static_cast<std::size_t>(row)];
  return std::isfinite(value) ? value : otherwise;
}

}  // namespace

CellModel::CellModel(const CellParameters& cell, OcvOf ocv) : cell_(cell), tables_(cell) {
  if (ocv == OcvOf::kSocTemperatureCurrent && !cell.ocv_table_v.empty()) ocv_by_test_.emplace(with_ocv_as_r0(cell));
}

double CellModel::ocv(double soc, double temperature_c, double current_a) const {
  const double curve = tables_.ocv_v(soc, temperature_c);
  if (!ocv_by_test_) return curve;
  // The breakpoints are coarser than the curve: only the difference from it is looked up there.
  const auto& at = cell_.soc_breakpoints;  // two or more: parameter_check
  const double inside = std::clamp(soc, at.front(), at.back());
  const auto above = std::upper_bound(at.begin() + 1, at.end() - 1, inside);
  const double left = *(above - 1), right = *above;
  const double straight =
      tables_.ocv(left).voltage_v +
      (tables_.ocv(right).voltage_v - tables_.ocv(left).voltage_v) * (inside - left) / (right - left);
  return curve + ocv_by_test_->circuit(soc, temperature_c, current_a).r0_ohm - straight;
}

RecordedTemperature::RecordedTemperature(const CellLog& log, double otherwise_c)
    : cell_c(log.temperature_c), ambient_c(log.ambient_c), start_c(otherwise_c) {
  const auto first = std::find_if(cell_c.begin(), cell_c.end(), [](double t) { return std::isfinite(t); });
  if (first == cell_c.end()) {
    cell_c.clear();
  } else {
    start_c = *first;
  }
}

CellResponse respond(const CellModel& model, const TestRun& run, const RecordedTemperature& temperature) {
  const Index rows = run.rows();
  CellResponse out{Eigen::VectorXd(rows), Eigen::VectorXd(rows), Eigen::VectorXd::Zero(rows)};
  const CellParameters& cell = model.cell();
  const double cooling = cell.convection_w_per_m2_k * cell.surface_area_m2,
               mass = cell.mass_kg * cell.heat_capacity_j_per_kg_k;
  const double floor = kLookupShare * run.current_a.cwiseAbs().maxCoeff();
  double v1 = 0.0, v2 = 0.0, lookup = 0.0, own = temperature.start_c, recorded = temperature.start_c;
  double ambient = temperature.start_c, surface = temperature.start_c;
  CellEffectState effects;
  CircuitParameters before{};
  for (Index row = 0; row < rows; ++row) {
    const double i = run.current_a(row), dt = run.dt_s(row);
    if (std::abs(i) > floor) lookup = std::abs(i);
    recorded = at_row(temperature.cell_c, row, recorded);
    // A surface was recorded: what is within is above it by as much as its own heat says.
    const double t = temperature.cell_c.empty() ? own : recorded + (own - surface);
    const CircuitParameters p = model.tables().circuit(run.soc(row), t, lookup);
    if (run.is_reset(row)) {
      v1 = v2 = 0.0;
      effects = {};
      own = surface = temperature.cell_c.empty() ? own : recorded;
    } else if (row > 0) {
      const double begin = run.current_begin_a(row), end = run.current_end_a(row);
      const IntervalResponse a = interval_response(dt, 0.5 * (before.tau1_s + p.tau1_s)),
                             b = interval_response(dt, 0.5 * (before.tau2_s + p.tau2_s));
      const double old1 = v1, old2 = v2;
      v1 = a.a * v1 + a.g0 * before.r1_ohm * begin + a.g1 * p.r1_ohm * end;
      v2 = b.a * v2 + b.g0 * before.r2_ohm * begin + b.g1 * p.r2_ohm * end;
      const double mean = 0.5 * (begin + end), mean1 = 0.5 * (old1 + v1), mean2 = 0.5 * (old2 + v2);
      if (has_dynamics(cell.effects)) advance(cell.effects, effects, begin, end, cell.capacity_ah, dt);
      const double heat = mean * mean * p.r0_ohm + mean1 * mean1 / p.r1_ohm + mean2 * mean2 / p.r2_ohm +
                          drop_of(cell.effects, effects) * mean + reversible_heat(cell.effects, mean, t);
      out.heat_w(row) = heat;
      const double target = ambient + (cooling > 0.0 ? heat / cooling : 0.0);
      const double was = own;
      own = cooling > 0.0 ? target + (own - target) * std::exp(-dt * cooling / mass) : own + heat * dt / mass;
      surface = surface_after(surface, was, own, cell.surface_lag_s, dt);
    }
    ambient = at_row(temperature.ambient_c, row, ambient);
    before = p;
    out.voltage(row) = model.ocv(run.soc(row), t, lookup) - p.r0_ohm * i - v1 - v2 -
                       drop_of(cell.effects, effects);
    out.temperature(row) = surface;
  }
  return out;
}

}  // namespace voltlap::plant
