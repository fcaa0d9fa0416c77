// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/circuit/circuit_model.hpp"

#include <algorithm>
#include <cmath>

#include "car/battery/first_order.hpp"
#include "learn/identify/recording/measured_run.hpp"

namespace voltlap::plant {

SocGrid::Place SocGrid::find(double soc) const {
  const auto above = std::upper_bound(at_.begin() + 1, at_.end() - 1, soc);
  const auto node = above - at_.begin() - 1;
  const double low = *(above - 1), high = *above;
  return {node, std::clamp((soc - low) / (high - low), 0.0, 1.0)};
}

SocGrid::Weights SocGrid::weights(double soc) const {
  return weights_within(std::clamp(soc, at_.front(), at_.back()));
}

SocGrid::Weights SocGrid::weights_within(double soc) const {
  const Eigen::Index first = std::clamp<Eigen::Index>(find(soc).node - 1, 0, size() - 4);
  const double x = soc;
  Weights out{first, {1.0, 1.0, 1.0, 1.0}};
  for (Eigen::Index k = 0; k < 4; ++k) {
    for (Eigen::Index other = 0; other < 4; ++other) {
      if (other == k) continue;
      out.weight[static_cast<std::size_t>(k)] *= (x - at(first + other)) / (at(first + k) - at(first + other));
    }
  }
  return out;
}

SocGrid::Weights SocGrid::slope_weights(double soc) const {
  constexpr double kStep = 1e-6;
  const double at_soc = std::clamp(soc, at_.front(), at_.back());
  const Weights here = weights_within(at_soc);
  const bool up = at_soc + kStep <= at_.back() && weights_within(at_soc + kStep).first == here.first;
  const Weights high = up ? weights_within(at_soc + kStep) : here, low = up ? here : weights_within(at_soc - kStep);
  Weights out{here.first, {}};
  for (std::size_t k = 0; k < 4; ++k) out.weight[k] = (high.weight[k] - low.weight[k]) / kStep;
  return out;
}

double SocGrid::value(const Eigen::Ref<const Eigen::VectorXd>& y, double soc) const {
  if (shape_ == Shape::kStraight) {
    const Place p = find(soc);
    return y(p.node) + p.fraction * (y(p.node + 1) - y(p.node));
  }
  const Weights w = weights(soc);
  double sum = 0.0;
  for (Eigen::Index k = 0; k < 4; ++k) sum += w.weight[static_cast<std::size_t>(k)] * y(w.first + k);
  return sum;
}

Eigen::MatrixXd SocGrid::roughness() const {
  const Eigen::Index n = size();
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(n - 2, n);
  for (Eigen::Index k = 1; k + 1 < n; ++k) {
    const double before = at(k) - at(k - 1), after = at(k + 1) - at(k),
                 scale = 1.0 / std::sqrt(0.5 * (before + after));
    rows(k - 1, k - 1) = scale / before;
    rows(k - 1, k) = -scale * (1.0 / before + 1.0 / after);
    rows(k - 1, k + 1) = scale / after;
  }
  return rows;
}

Eigen::MatrixXd SocGrid::slopes() const {
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(size() - 1, size());
  rows.diagonal().setConstant(-1.0);
  rows.diagonal(1).setConstant(1.0);
  return rows;
}

SocGrid breakpoint_grid() {
  return SocGrid({0.001, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.85, 0.9, 0.95, 1.0});
}

SocGrid halved(const SocGrid& grid) {
  std::vector<double> at{grid.at(0)};
  for (Eigen::Index k = 1; k < grid.size(); ++k) {
    at.push_back(0.5 * (grid.at(k - 1) + grid.at(k)));
    at.push_back(grid.at(k));
  }
  return SocGrid(std::move(at));
}

SocGrid ocv_grid() {
  std::vector<double> at;
  for (int k = 0; k < 12; ++k) at.push_back(k / 120.0);
  for (int k = 4; k < 37; ++k) at.push_back(k / 40.0);
  for (int k = 111; k <= 120; ++k) at.push_back(k / 120.0);
  return SocGrid(std::move(at), SocGrid::Shape::kSmooth);
}

IntervalResponse interval_response(double dt_s, double tau_s) {
  const FirstOrderStep step = first_order_step(dt_s, tau_s);
  const double a = step.keep, da = a * dt_s / (tau_s * tau_s), dx = (1.0 - a) / dt_s - a / tau_s;
  return {a, step.from_begin, step.from_end, da, dx - da, -dx};
}

namespace {

/// Linear in SOC between the nodes of one column of a table.
double entry(const Eigen::MatrixXd& table, Eigen::Index column, const SocGrid::Place& at) {
  return table(at.node, column) + at.fraction * (table(at.node + 1, column) - table(at.node, column));
}

}  // namespace

Eigen::VectorXd simulate(const CircuitModel& model, const MeasuredRun& run,
                         const Eigen::Ref<const Eigen::VectorXd>& states_v, Eigen::VectorXd* after_v) {
  const Eigen::Index branches = model.branches();
  Eigen::VectorXd voltage(run.rows()), state = Eigen::VectorXd::Zero(branches), resistance = state, before = state;
  Eigen::Index next_state = 0;
  double shown = 0.0, turned = hysteresis_at_begin(run.soc(0));
  for (Eigen::Index row = 0; row < run.rows(); ++row) {
    const SocGrid::Place p = model.grid.find(run.soc(row));
    const LawFactors laws = law_factors(model.laws, run.temperature_c(row));
    for (Eigen::Index k = 0; k < branches; ++k)
      resistance(k) = laws.resistance[static_cast<std::size_t>(k)] * entry(model.r, k + 1, p);
    if (run.is_reset(row)) {
      state.setZero();
      if (!run.at_rest_before[static_cast<std::size_t>(row)] && next_state + branches <= states_v.size()) {
        state = states_v.segment(next_state, branches);
        next_state += branches;
      }
    } else {
      const SocGrid::Place middle = model.grid.find(0.5 * (run.soc(row) + run.soc(row - 1)));
      for (Eigen::Index k = 0; k < branches; ++k) {
        const double tau_s = laws.time_constant[static_cast<std::size_t>(k)] * entry(model.tau, k, middle);
        state(k) = first_order_step(run.dt_s(row), tau_s)
                       .after(state(k), before(k) * run.current_begin_a(row), resistance(k) * run.current_end_a(row));
      }
    }
    before = resistance;
    const double drop = laws.ohmic * entry(model.r, 0, p) * run.current_a(row) +
                        charge_transfer_drop_v(model.laws, run.current_a(row), run.temperature_c(row));
    if (row > 0 && model.laws.has_hysteresis())
      turned = hysteresis_after(turned, model.laws.hysteresis_per_soc, run.soc(row - 1) - run.soc(row));
    const double warmer_k = run.temperature_c(row) - model.laws.reference_temperature_c;
    const double moved_mv = model.laws.entropy_mv_per_k * warmer_k - model.laws.hysteresis_mv * turned;
    const double v = model.ocv.value(model.em, run.soc(row)) + 1e-3 * moved_mv - drop - state.sum();
    const bool lags = model.voltage_lag_s > 0.0 && row > 0 && !run.is_reset(row);
    shown = lags ? v + (shown - v) * std::exp(-run.dt_s(row) / model.voltage_lag_s) : v;
    voltage(row) = shown;
  }
  if (after_v != nullptr) *after_v = state;
  return voltage;
}

}  // namespace voltlap::plant
