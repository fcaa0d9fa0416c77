// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/preparation/hysteresis.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "car/battery/cell_effects.hpp"
#include "core/demand.hpp"
#include "core/errors.hpp"
#include "core/signal.hpp"
#include "learn/identify/circuit/fitted_circuit.hpp"
#include "learn/identify/preparation/first_estimates.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;

constexpr double kSlow = 1.0 / 8.0, kBin = 0.05;  // C-rate; SOC
constexpr double kExcited = 10.0;                 // s of fast current that make a bin of SOC known

int bin_of(double soc) { return static_cast<int>(std::floor(soc / kBin)); }

bool is_slow(double current_a, double capacity_ah) {
  return std::abs(current_a) < kSlow * capacity_ah && std::abs(current_a) > 1e-3 * capacity_ah;
}

/// Sums over the rows of a bin in which the current went one way.
struct Side {
  double weight = 0.0, voltage = 0.0, current = 0.0;
};
using Sides = std::array<Side, 2>;  // discharge, charge

constexpr int kFirstBin = 2, kLastBin = 17;  // at the ends the OCV is too steep, and a step is no resistance

/// Mean temperature of the rows with a slow current [degC].
double slow_temperature(const std::vector<MeasuredRun>& runs, double capacity_ah) {
  double sum = 0.0, weight = 0.0;
  for (const MeasuredRun& run : runs) {
    for (Index row = 0; row < run.rows(); ++row) {
      if (!is_slow(run.current_a(row), capacity_ah)) continue;
      sum += run.weight_s(row) * run.temperature_c(row);
      weight += run.weight_s(row);
    }
  }
  return weight > 0.0 ? sum / weight : 25.0;
}

/// Of a step at the temperature of the slow rows [ohm], by the steps between the ends, of the recordings nearest to it
/// by a usual law (its own may make three times as much of the cold); without any there at most what the cells of a car
/// have.
double step_resistance(const std::vector<MeasuredRun>& runs, double capacity_ah) {
  constexpr double kMost_v = 0.15;  // at 1C
  constexpr double kAlike_k = 5.0;  // within it a usual law is as good as another
  CellEffects usual;
  usual.activation_energy_j_per_mol = 25e3;
  const double slow_c = slow_temperature(runs, capacity_ah);
  std::map<int, std::vector<double>> by_distance;  // from that temperature, in steps of kAlike_k
  for (const MeasuredRun& run : runs) {
    const double mean_c = run.temperature_c.mean(), factor = resistance_factor(usual, 1.0, slow_c, mean_c);
    for (const StepEstimate& step : resistance_steps(run)) {
      const int bin = bin_of(step.soc);
      if (bin < kFirstBin || bin > kLastBin) continue;
      by_distance[static_cast<int>(std::abs(mean_c - slow_c) / kAlike_k)].push_back(factor * step.resistance_ohm);
    }
  }
  if (!by_distance.empty()) return median(std::move(by_distance.begin()->second));
  return std::min(resistance_step_median(runs), kMost_v / kWholeOverStep / capacity_ah);
}

/// By bin of SOC, rows with a slow current that has lasted.
std::map<int, Sides> slow_sides(const std::vector<MeasuredRun>& runs, double capacity_ah) {
  constexpr double kSteady = 300.0;  // s
  std::map<int, Sides> bins;
  for (const MeasuredRun& run : runs) {
    double steady = 0.0;
    for (Index row = 1; row < run.rows(); ++row) {
      const double i = run.current_a(row);
      steady = is_slow(i, capacity_ah) && i * run.current_a(row - 1) > 0.0 ? steady + run.dt_s(row) : 0.0;
      if (steady < kSteady || run.weight_s(row) <= 0.0) continue;
      Side& side = bins[bin_of(run.soc(row))][i > 0.0 ? 0 : 1];
      side.weight += run.weight_s(row);
      side.voltage += run.weight_s(row) * run.voltage_v(row);
      side.current += run.weight_s(row) * std::abs(i);
    }
  }
  return bins;
}

/// Seconds of fast current by bin of SOC.
std::map<int, double> fast_seconds(const std::vector<MeasuredRun>& runs, double capacity_ah) {
  std::map<int, double> fast_s;
  for (const MeasuredRun& run : runs) {
    for (Index row = 0; row < run.rows(); ++row) {
      const bool fast = std::abs(run.current_a(row)) >= kSlow * capacity_ah;
      if (fast && run.weight_s(row) > 0.0) fast_s[bin_of(run.soc(row))] += run.dt_s(row);
    }
  }
  return fast_s;
}

/// How fast a change of direction turns the state, by the cost of quick fits.
double best_per_soc(const std::vector<MeasuredRun>& runs, FitPriors priors) {
  double best = 0.0, least = 1e300;
  for (const double tried : {5.0, 10.0, 20.0, 40.0, 80.0, 160.0}) {
    priors.laws.hysteresis_per_soc = tried;
    const double cost = linear_fit(runs, first_taus(2), priors).solution.cost;
    if (cost >= least) continue;
    least = cost;
    best = tried;
  }
  return best;
}

/// Half of what stands between slow charge and slow discharge at the same SOC, and what a circuit's own drop is of it.
struct HysteresisPoint {
  double soc, middle_v, half_gap_v, step_v;
};

std::vector<HysteresisPoint> hysteresis_of(const std::vector<MeasuredRun>& runs, double capacity_ah) {
  const double resistance = step_resistance(runs, capacity_ah);
  std::vector<HysteresisPoint> out;
  for (const auto& [bin, sides] : slow_sides(runs, capacity_ah)) {
    const auto& [discharge, charge] = sides;
    if (bin < kFirstBin || bin > kLastBin || discharge.weight <= 0.0 || charge.weight <= 0.0) continue;
    const double down = discharge.voltage / discharge.weight, up = charge.voltage / charge.weight;
    const double current = 0.5 * (discharge.current / discharge.weight + charge.current / charge.weight);
    out.push_back({kBin * (bin + 0.5), 0.5 * (up + down), 0.5 * (up - down), current * resistance});
    VOLTLAP_DEMAND(within(out.back().soc, 0.0, 1.0));
  }
  return out;
}

/// Mean half gap [V] beyond `whole` steps of the resistance, where it is that of a chemistry in three bins of SOC or
/// more; else 0.
double excess_over(const std::vector<HysteresisPoint>& points, double whole) {
  constexpr double kLeast = 5e-3, kMost = 0.1;  // V; beyond, a SOC that has drifted between the two, of no chemistry
  constexpr std::size_t kFewestPoints = 3;
  double excess = 0.0;
  for (const HysteresisPoint& point : points)
    excess += (point.half_gap_v - whole * point.step_v) / static_cast<double>(points.size());
  return points.size() < kFewestPoints || excess < kLeast || excess > kMost ? 0.0 : excess;
}

}  // namespace

Hysteresis take_hysteresis(const std::vector<MeasuredRun>& runs, double capacity_ah, double steps, FitPriors& priors,
                           std::vector<std::string>& notes) {
  VOLTLAP_DEMAND(!runs.empty() && steps > 0.0);
  constexpr int kFewestExcited = 5;
  constexpr double kMillivolts = 1e3, kUncertain = 0.5;  // of the excess
  const std::vector<HysteresisPoint> points = hysteresis_of(runs, capacity_ah);
  const double excess = excess_over(points, steps);
  if (excess == 0.0) return {0.0, excess_over(points, 1.0) > 0.0};
  const std::string what = fmt::format(
      "Hysteresis: slow charge and slow discharge stand {:.1f} mV apart beyond what resistance explains", 2e3 * excess);
  const std::map<int, double> fast_s = fast_seconds(runs, capacity_ah);
  const auto excited =
      std::count_if(fast_s.begin(), fast_s.end(), [](const auto& bin) { return bin.second > kExcited; });
  if (excited < kFewestExcited) {
    throw InputError(runs.front().name, what, "pulses or a drive beside the slow test",
                     "Give another recording of this cell with currents above C/8, and this one beside it");
  }
  for (const HysteresisPoint& point : points)
    priors.ocv.push_back({point.soc, point.middle_v, point.half_gap_v});
  priors.laws.hysteresis_mv = kMillivolts * excess;
  priors.laws.hysteresis_per_soc = best_per_soc(runs, priors);
  priors.law_priors.mean(ResistanceLaws::kHysteresis) = kMillivolts * excess;
  priors.law_priors.sigma(ResistanceLaws::kHysteresis) = kUncertain * kMillivolts * excess;
  notes.push_back(fmt::format("{}: a state of the model (Plett, 2004) that a change of direction turns within {:.1f} % "
                              "of the charge.",
                              what, 100.0 / priors.laws.hysteresis_per_soc));
  return {excess, false};
}

}  // namespace voltlap::plant
