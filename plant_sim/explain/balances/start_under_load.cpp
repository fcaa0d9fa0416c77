// SPDX-License-Identifier: Apache-2.0
#include "explain/balances/start_under_load.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "car/battery/cell_tables.hpp"
#include "core/signal.hpp"

namespace voltlap::plant {
namespace {

constexpr double kWorthIt_v = 0.02;  // of a cell; with less the fit itself finds what was charged before

using Eigen::Index;
using Eigen::VectorXd;

/// What the model leaves of the first channel [V a cell], nothing where nothing was read.
VectorXd left_of(const World& model, double cells, const Comparison& comparison) {
  VectorXd out = (comparison.channels[0].measured - predict(model, comparison).channels[0]) / cells;
  for (double& v : out) v = std::isfinite(v) ? v : 0.0;
  return out;
}

double left_v(const World& model, double cells, const Comparison& comparison) {
  return std::sqrt(left_of(model, cells, comparison).squaredNorm() / static_cast<double>(comparison.log.rows()));
}

/// Where nothing tells the SOC that a log begins with, the one with which the model is right in the first minute.
void settle_soc(const World& model, double cells, Comparison& out) {
  constexpr double kMinute = 60.0, kEnough = 1e-5;  // s, SOC
  constexpr int kMostSteps = 10;                    // the drop follows the SOC, the SOC the drop
  const CellTables tables(model.car.cell);
  for (int step = 0; step < kMostSteps; ++step) {
    const Prediction p = predict(model, out);
    std::vector<double> change;
    for (Index row = 0; row < out.log.rows() && out.log.time_s(row) <= out.log.time_s(0) + kMinute; ++row) {
      const double missing = (out.channels[0].measured(row) - p.channels[0](row)) / cells;
      const double at_c =
          out.facts.temperature_c.size() > 0 ? out.facts.temperature_c(row) : p.battery.temperature_c(row);
      const double ocv = p.battery.voltage_v(row) + p.battery.drop_v(row) + missing;
      if (std::isfinite(ocv)) change.push_back(tables.soc_of_ocv(ocv, at_c) - p.battery.soc(row));
    }
    if (change.empty()) return;
    const double before = out.facts.initial_soc;
    out.facts.initial_soc = std::clamp(before + median(change), 0.0, 1.0);
    if (std::abs(out.facts.initial_soc - before) < kEnough) return;
  }
}

/// How full and how charged, by least squares over the whole log from where it is: the one alone looks like the other
/// in the first minutes. What the log says of the SOC is left as it is.
void settle_both(const World& model, double cells, Comparison& out) {
  constexpr int kMostSteps = 8, kMostHalvings = 4;
  constexpr double kStep = 0.002, kMostCharge = 2.0, kEnough = 0.999;
  const double usual_a = out.facts.charged_before_a;
  const auto put = [&](const Eigen::Vector2d& at) {
    out.facts.initial_soc = at(0);
    out.facts.charged_before_a = at(1) * usual_a;
  };
  const auto left_at = [&](const Eigen::Vector2d& at) {
    put(at);
    return left_of(model, cells, out);
  };
  const bool known = out.log.find("soc") != nullptr;
  Eigen::Vector2d at{out.facts.initial_soc, 1.0};
  VectorXd left = left_at(at);
  for (int step = 0; step < kMostSteps; ++step) {
    Eigen::MatrixX2d slopes(left.size(), 2);
    slopes.col(0) = known ? VectorXd(VectorXd::Zero(left.size()))
                          : VectorXd((left_at(at + Eigen::Vector2d{kStep, 0.0}) - left) / kStep);
    slopes.col(1) = (left_at(at + Eigen::Vector2d{0.0, kStep}) - left) / kStep;
    Eigen::Vector2d by = -slopes.colPivHouseholderQr().solve(left);
    bool fell = false;
    for (int halving = 0; halving < kMostHalvings && !fell; ++halving, by /= 2.0) {
      const Eigen::Vector2d next{std::clamp(at(0) + by(0), 0.0, 1.0), std::clamp(at(1) + by(1), 0.0, kMostCharge)};
      const VectorXd left_there = left_at(next);
      if (left_there.squaredNorm() >= kEnough * left.squaredNorm()) continue;
      fell = true;
      at = next;
      left = left_there;
    }
    if (!fell) break;
  }
  put(at);
}

/// As the log goes on, it was before.
void settle_charge(const World& model, double cells, Comparison& out) {
  constexpr double kMinutes_s = 300.0, kBetter = 0.5;  // chosen
  const double rested_v = left_v(model, cells, out), rested_soc = out.facts.initial_soc;
  if (rested_v < kWorthIt_v) return;
  const VectorXd& current = *out.log.find("current");
  double sum = 0.0, count = 0.0;
  for (Index row = 0; row < out.log.rows() && out.log.time_s(row) <= out.log.time_s(0) + kMinutes_s; ++row) {
    if (!std::isfinite(current(row))) continue;
    sum += current(row);
    count += 1.0;
  }
  out.facts.charged_before_a = sum / std::max(1.0, count) / std::max(1, model.car.battery.cells_in_parallel);
  if (out.log.find("soc") == nullptr) settle_soc(model, cells, out);
  if (out.facts.charged_before_a > 0.0) settle_both(model, cells, out);
  if (left_v(model, cells, out) < kBetter * rested_v) return;
  out.facts.charged_before_a = 0.0;
  out.facts.initial_soc = rested_soc;
}

/// By a log that begins amid a drive.
void settle_without_rest(const World& model, double cells, Comparison& out) {
  out.facts.starts_at_rest = false;
  if (out.log.find("soc") == nullptr) settle_soc(model, cells, out);
  settle_charge(model, cells, out);
}

}  // namespace

void settle_start_under_load(const World& model, double cells, Comparison& out) {
  constexpr double kShort_s = 60.0, kFarBetter = 1.0 / 3.0;  // chosen
  if (!out.facts.starts_at_rest) return settle_without_rest(model, cells, out);
  if (out.facts.first_rest_s > kShort_s) return;
  const double by_rest_v = left_v(model, cells, out);
  if (by_rest_v < kWorthIt_v) return;
  const LogFacts rested = out.facts;
  settle_without_rest(model, cells, out);
  if (left_v(model, cells, out) > kFarBetter * by_rest_v) out.facts = rested;
}

}  // namespace voltlap::plant
