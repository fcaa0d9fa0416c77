// SPDX-License-Identifier: Apache-2.0
#include "explain/model/beginning.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "car/battery/cell.hpp"

namespace voltlap::explain {
namespace {

constexpr double kFirst_s = 180.0, kLeast_s = 30.0;
constexpr double kSeen = 0.1;  // practical sizes of error: with less there is nothing to tell

/// Squares that least squares leave of `y`.
double squares_left(const MatrixXd& x, const VectorXd& y) {
  const VectorXd scale = x.colwise().norm().cwiseMax(1e-300).cwiseInverse();
  const MatrixXd scaled = x * scale.asDiagonal();
  return (y - scaled * scaled.colPivHouseholderQr().solve(y)).squaredNorm();
}

plant::CircuitParameters circuit_at(const plant::CellParameters& cell, double soc, double at_c) {
  return plant::CellTables(cell).circuit(soc, at_c, cell.reference_current_a);
}

/// What the log counted over a gap, or a BMS says; NaN: neither.
double soc_told(const plant::World& model, const plant::Comparison& comparison, Index row) {
  const plant::LogFacts& facts = comparison.facts;
  const double seconds = comparison.log.time_s(row) - comparison.log.time_s(row - 1);
  if (facts.counted_a.size() > 0 && std::isfinite(facts.counted_a(row))) {
    const plant::CellInterval counted{seconds, facts.counted_a(row), facts.counted_a(row)};
    return -plant::soc_drawn(counted, model.car.cell.capacity_ah * model.car.battery.cells_in_parallel);
  }
  const VectorXd* soc = comparison.log.find("soc");
  if (soc == nullptr) return std::numeric_limits<double>::quiet_NaN();
  Index before = row - 1;
  while (before > 0 && !std::isfinite((*soc)(before))) --before;
  while (row + 1 < soc->size() && !std::isfinite((*soc)(row))) ++row;
  return (*soc)(row) - (*soc)(before);
}

/// Change of the SOC at a row with which, beside charged branches and errors of resistance, the voltage of the first
/// minutes from there is the measured one. What is left says how well each second of it is known.
double soc_missing(const plant::CellParameters& cell, const plant::Comparison& comparison,
                   const plant::BatteryResponse& battery, Index from) {
  constexpr double kSoc = 0.05, kLaw = 0.3, kFinest_v = 1e-3;  // standard deviations
  constexpr int kPasses = 3;
  const VectorXd& time_s = comparison.log.time_s;
  Index rows = 0;
  while (from + rows < time_s.size() && time_s(from + rows) < time_s(from) + kFirst_s) ++rows;
  const auto branches = static_cast<Index>(cell.branch_count());
  const double usual_a = std::sqrt(battery.current_a.squaredNorm() / static_cast<double>(time_s.size()));
  const plant::CircuitParameters circuit = circuit_at(cell, battery.soc(from), battery.temperature_c(from));
  MatrixXd x(rows, branches + 3);
  x.col(0) = kSoc * battery.ocv_slope_v.segment(from, rows);
  x.col(1) = kLaw * circuit.r0_ohm * battery.current_a.segment(from, rows);
  x.col(2) = kLaw * battery.drop_v.segment(from, rows);
  for (Index b = 0; b < branches; ++b) {
    const auto k = static_cast<std::size_t>(b);
    x.col(3 + b) = usual_a * circuit.r_ohm[k] *
                   (-(time_s.segment(from, rows).array() - time_s(from)) / circuit.tau_s[k]).exp();
  }
  VectorXd y = comparison.facts.voltage_v.segment(from, rows) - battery.voltage_v.segment(from, rows);
  for (Index row = 0; row < rows; ++row) {
    if (std::isfinite(y(row))) continue;
    y(row) = 0.0;
    x.row(row).setZero();
  }
  const double seconds = std::max(1.0, time_s(from + rows - 1) - time_s(from));
  VectorXd size = VectorXd::Zero(x.cols());
  for (int pass = 0; pass < kPasses; ++pass) {
    const double left = std::max(kFinest_v * kFinest_v, (y - x * size).squaredNorm() / static_cast<double>(rows));
    const double weight = seconds / (left * static_cast<double>(rows));
    MatrixXd normal = weight * x.transpose() * x;
    normal.diagonal().array() += 1.0;
    size = normal.ldlt().solve(weight * (x.transpose() * y));
  }
  return kSoc * size(0);
}

}  // namespace

double left_beside_charge(const Observed& log) {
  const ReadChannel& channel = log.channels.front();
  const plant::BatteryResponse& battery = log.base.battery;
  const VectorXd& time_s = channel.reader.time_s();
  const double begin_s = log.comparison.log.time_s(0);
  Index bins = 0;
  while (bins < time_s.size() && time_s(bins) < begin_s + kFirst_s) ++bins;
  if (bins == 0 || time_s(bins - 1) < begin_s + kLeast_s) return 1.0;
  const VectorXd since_s = time_s.head(bins).array() - begin_s, y = channel.residual.head(bins);
  const plant::CellParameters& cell = log.model.car.cell;
  const auto known = static_cast<Index>(4), branches = static_cast<Index>(cell.branch_count());
  if (bins < 2 * (known + branches)) return 1.0;
  const plant::CircuitParameters circuit =
      circuit_at(cell, battery.soc(0), log.comparison.facts.initial_temperature_c);
  MatrixXd x(bins, known + branches);
  x.col(0).setOnes();
  x.col(1) = since_s;
  x.col(2) = channel.reader.of(battery.current_a).head(bins);
  x.col(3) = channel.reader.of(battery.drop_v).head(bins);
  for (Index b = 0; b < branches; ++b)
    x.col(known + b) = (-since_s.array() / circuit.tau_s[static_cast<std::size_t>(b)]).exp();
  const double before = squares_left(x.leftCols(known), y);
  if (before < static_cast<double>(bins) * kSeen * kSeen * channel.practical * channel.practical) return 1.0;
  return squares_left(x, y) / before;
}

void settle_gaps(const plant::World& model, plant::Comparison& comparison) {
  constexpr int kRounds = 3;  // the open-circuit voltage bends
  plant::LogFacts& facts = comparison.facts;
  if (facts.voltage_v.size() == 0) return;
  facts.soc_after_gap.assign(facts.gaps.size(), 0.0);
  for (std::size_t gap = 0; gap < facts.gaps.size(); ++gap) {
    const double told = soc_told(model, comparison, facts.gaps[gap]);
    if (std::isfinite(told)) {
      facts.soc_after_gap[gap] = told;
      continue;
    }
    for (int round = 0; round < kRounds; ++round) {
      const plant::BatteryResponse battery = plant::battery_response(model, comparison.log, facts);
      facts.soc_after_gap[gap] += soc_missing(model.car.cell, comparison, battery, facts.gaps[gap]);
    }
  }
}

}  // namespace voltlap::explain
