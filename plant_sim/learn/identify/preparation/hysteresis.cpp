// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/preparation/hysteresis.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "core/demand.hpp"
#include "core/errors.hpp"
#include "core/signal.hpp"
#include "learn/identify/preparation/first_estimates.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;

constexpr double kSlow = 1.0 / 8.0, kBin = 0.05;  // C-rate; SOC
constexpr double kExcited = 10.0;                 // s of fast current that make a bin of SOC known

int bin_of(double soc) { return static_cast<int>(std::floor(soc / kBin)); }

/// Sums over the rows of a bin in which the current went one way.
struct Side {
  double weight = 0.0, voltage = 0.0, current = 0.0;
};
using Sides = std::array<Side, 2>;  // discharge, charge

/// By bin of SOC, rows with a slow current that has lasted.
std::map<int, Sides> slow_sides(const std::vector<MeasuredRun>& runs, double capacity_ah) {
  constexpr double kSteady = 300.0;  // s
  std::map<int, Sides> bins;
  for (const MeasuredRun& run : runs) {
    double steady = 0.0;
    for (Index row = 1; row < run.rows(); ++row) {
      const double i = run.current_a(row);
      const bool slow = std::abs(i) < kSlow * capacity_ah && std::abs(i) > 1e-3 * capacity_ah;
      steady = slow && i * run.current_a(row - 1) > 0.0 ? steady + run.dt_s(row) : 0.0;
      if (steady < kSteady || run.weight_s(row) <= 0.0) continue;
      Side& side = bins[bin_of(run.soc(row))][i > 0.0 ? 0 : 1];
      side.weight += run.weight_s(row);
      side.voltage += run.weight_s(row) * run.voltage_v(row);
      side.current += run.weight_s(row) * std::abs(i);
    }
  }
  return bins;
}

/// Rows behind fast currents keep their weight, the others lose it. Returns seconds of fast current by bin of SOC.
std::map<int, double> keep_fast_rows(std::vector<MeasuredRun>& runs, double capacity_ah) {
  constexpr double kWindow = 120.0;  // s
  std::map<int, double> fast_s;
  for (MeasuredRun& run : runs) {
    double since_fast = 1e9;
    for (Index row = 0; row < run.rows(); ++row) {
      const bool fast = std::abs(run.current_a(row)) >= kSlow * capacity_ah;
      since_fast = fast ? 0.0 : since_fast + run.dt_s(row);
      if (since_fast > kWindow) run.weight_s(row) = 0.0;
      if (fast && run.weight_s(row) > 0.0) fast_s[bin_of(run.soc(row))] += run.dt_s(row);
    }
  }
  return fast_s;
}

}  // namespace

std::vector<HysteresisPoint> hysteresis_of(const std::vector<MeasuredRun>& runs, double capacity_ah) {
  constexpr double kWhole = 3.0;  // both branches add about as much again as the step shows, each
  constexpr int kFirstBin = 2, kLastBin = 17;  // at the ends the OCV is too steep
  const double resistance = kWhole * resistance_step_median(runs);
  std::vector<HysteresisPoint> out;
  for (const auto& [bin, sides] : slow_sides(runs, capacity_ah)) {
    const auto& [discharge, charge] = sides;
    if (bin < kFirstBin || bin > kLastBin || discharge.weight <= 0.0 || charge.weight <= 0.0) continue;
    const double down = discharge.voltage / discharge.weight, up = charge.voltage / charge.weight;
    const double current = 0.5 * (discharge.current / discharge.weight + charge.current / charge.weight);
    const double half = 0.5 * (up - down);
    out.push_back({kBin * (bin + 0.5), 0.5 * (up + down), half, half - current * resistance});
    VOLTLAP_DEMAND(within(out.back().soc, 0.0, 1.0));
  }
  return out;
}

double set_hysteresis_aside(std::vector<MeasuredRun>& runs, double capacity_ah, FitPriors& priors,
                            std::vector<std::string>& notes) {
  VOLTLAP_DEMAND(!runs.empty());
  constexpr double kLeast = 5e-3, kMost = 0.1;  // V; beyond, a SOC that has drifted between the two, of no chemistry
  constexpr std::size_t kFewestPoints = 3;
  constexpr int kFewestExcited = 5;
  const auto points = hysteresis_of(runs, capacity_ah);
  double excess = 0.0;
  for (const HysteresisPoint& point : points) excess += point.excess_v / static_cast<double>(points.size());
  if (points.size() < kFewestPoints || excess < kLeast || excess > kMost) return 0.0;
  notes.push_back(
      fmt::format("Hysteresis: slow charge and slow discharge stand {:.1f} mV apart beyond what resistance "
                  "explains. This circuit cannot represent it: the OCV is their middle, and the slow rows "
                  "are kept out of the resistances and time constants.",
                  2e3 * excess));
  for (const HysteresisPoint& point : points) priors.ocv.push_back({point.soc, point.middle_v, point.half_gap_v});
  const std::map<int, double> fast_s = keep_fast_rows(runs, capacity_ah);
  const auto excited =
      std::count_if(fast_s.begin(), fast_s.end(), [](const auto& bin) { return bin.second > kExcited; });
  if (excited < kFewestExcited) {
    throw InputError(runs.front().name, notes.back(), "pulses or a drive beside the slow test",
                     "Give another recording of this cell with currents above C/8, and this one beside it");
  }
  return excess;
}

}  // namespace voltlap::plant
