// SPDX-License-Identifier: Apache-2.0
#include "learn/validate/cell_response.hpp"

#include <algorithm>
#include <cmath>

#include "core/errors.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;

constexpr double kLookupShare = 0.005;  // of the largest current: smaller ones keep the last lookup current

/// The cell with its open-circuit voltages in the place of R0.
CellParameters with_ocv_as_r0(CellParameters cell) {
  cell.r0_ohm = {{}, 0.0, 0.0, cell.ocv_table_v};
  return cell;
}

/// The next branch voltages of those that are given, if any are left.
void take_free(const Eigen::VectorXd& states_v, Index& next, Index branches, CellState& state) {
  if (next + branches > states_v.size()) return;
  for (Index k = 0; k < branches; ++k) state.v[static_cast<std::size_t>(k)] = states_v(next + k);
  next += branches;
}

double at_row(const std::vector<double>& values, Index row, double otherwise) {
  if (values.empty()) return otherwise;
  const double value = values[static_cast<std::size_t>(row)];
  return std::isfinite(value) ? value : otherwise;
}

}  // namespace

CellModel::CellModel(const CellParameters& cell, OcvOf ocv) : cell_(cell) {
  if (ocv == OcvOf::kSocTemperatureCurrent && !cell.ocv_table_v.empty()) ocv_by_test_.emplace(with_ocv_as_r0(cell));
}

double CellModel::ocv(double soc, double temperature_c, double current_a) const {
  const CellTables& tables = cell_.tables();
  const double curve = tables.ocv_v(soc, temperature_c);
  if (!ocv_by_test_) return curve;
  // The breakpoints are coarser than the curve: only the difference from it is looked up there.
  const auto& at = cell_.parameters().soc_breakpoints;  // two or more: parameter_check
  const double inside = std::clamp(soc, at.front(), at.back());
  const auto above = std::upper_bound(at.begin() + 1, at.end() - 1, inside);
  const double left = *(above - 1), right = *above;
  const double straight =
      tables.ocv(left).voltage_v +
      (tables.ocv(right).voltage_v - tables.ocv(left).voltage_v) * (inside - left) / (right - left);
  return curve + ocv_by_test_->circuit(soc, temperature_c, current_a).r0_ohm - straight;
}

RecordedTemperature::RecordedTemperature(const CellLog& log, double otherwise_c, bool told)
    : cell_c(log.temperature_c), ambient_c(log.ambient_c), start_c(otherwise_c) {
  const auto first_of = [](const std::vector<double>& readings) {
    const auto first = std::find_if(readings.begin(), readings.end(), [](double t) { return std::isfinite(t); });
    return first == readings.end() ? std::optional<double>() : *first;
  };
  const std::optional<double> cell = first_of(cell_c), ambient = first_of(ambient_c);
  if (!cell) cell_c.clear();
  if (told) start_from = "--temperature";
  if (cell || (ambient && !told)) {
    start_c = cell ? *cell : *ambient;
    start_from = cell ? "recorded" : "its ambient";
  }
}

CellResponse respond(const CellModel& model, const MeasuredRun& run, const RecordedTemperature& temperature,
                     const Eigen::VectorXd& states_v) {
  const Index rows = run.rows();
  const Cell& cell = model.one_cell();
  const bool recorded_cell = !temperature.cell_c.empty();
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(rows);
  CellResponse out{none, none, none, none};
  CellState state;
  state.lookup_floor_a = kLookupShare * run.current_a.cwiseAbs().maxCoeff();
  state.temperature_c = state.surface_c = temperature.start_c;
  double recorded = temperature.start_c, air = temperature.start_c;
  const auto branches = static_cast<Index>(cell.parameters().branch_count());
  Index next_free = 0;
  for (Index row = 0; row < rows; ++row) {
    recorded = at_row(temperature.cell_c, row, recorded);
    // What was recorded is what the tables were identified with: nothing is put on top of it.
    const double at_c = recorded_cell ? recorded : state.temperature_c;
    const CellPoint end{run.current_a(row), run.soc(row), at_c};
    if (run.is_reset(row) || row == 0) {
      cell.look_up(state, end);
      state.relax();
      if (!run.at_rest_before[static_cast<std::size_t>(row)]) take_free(states_v, next_free, branches, state);
      state.effects.hysteresis = hysteresis_at_begin(end.soc);
      if (recorded_cell) state.temperature_c = recorded;
      state.surface_c = state.temperature_c;
    } else {
      const CellInterval interval{run.dt_s(row), run.current_begin_a(row), run.current_end_a(row)};
      out.reversible_w(row) = cell.reversible_w(interval.mean_a(), at_c);
      out.heat_w(row) = cell.advance(state, interval, end) + out.reversible_w(row);
      warm(state, cell.thermal(), out.heat_w(row), air, interval.dt_s);
    }
    air = at_row(temperature.ambient_c, row, air);
    out.voltage(row) = model.ocv(end.soc, at_c, state.lookup_a) - cell.drop_v(state, end.current_a);
    out.temperature(row) = state.surface_c;
  }
  return out;
}

}  // namespace voltlap::plant
