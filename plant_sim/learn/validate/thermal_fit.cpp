// SPDX-License-Identifier: Apache-2.0
#include "learn/validate/thermal_fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/demand.hpp"
#include "core/errors.hpp"
#include "learn/validate/thermal_system.hpp"
#include "learn/validate/thermal_uncertainty.hpp"

namespace voltlap::plant {
namespace {

constexpr double kLeastRise = 1.0;                   // K; below it a heat capacity is noise
constexpr double kRateLow = 1e-6, kRateHigh = 3e-2;  // 1/s of G / C: 12 days to half a minute
constexpr double kLongestLag = 600.0;                // s
constexpr double kLeastNoise_k = 0.01;               // no thermometer in a log does better

using Recordings = std::vector<ThermalRecording>;

void require_rise(const Recordings& recordings) {
  double rise = 0.0;
  for (const ThermalRecording& r : recordings) {
    double low = 1e9, high = -1e9;
    for (const double t : r.temperature_c) {
      if (!std::isfinite(t)) continue;
      low = std::min(low, t);
      high = std::max(high, t);
    }
    rise = std::max(rise, high - low);
  }
  if (rise >= kLeastRise) return;
  throw InputError(
      recordings.empty() ? "thermal model" : recordings.front().file,
      recordings.empty() ? "no recorded temperature" : fmt::format("temperatures within {:.2g} K", rise),
      fmt::format("temperatures that change by {} K or more", kLeastRise),
      "Give a recording in which the cell warms itself, with a temperature column");
}

/// Without a lag.
double best_rate(const Recordings& recordings, double variance) {
  double centre = std::log(kRateLow), best = 1e300;
  const auto look = [&](double log_rate) {
    if (log_rate < std::log(kRateLow) || log_rate > std::log(kRateHigh)) return;
    const double cost = solve_thermal(recordings, {std::exp(log_rate), 0.0}, variance).cost;
    if (cost >= best) return;
    best = cost;
    centre = log_rate;
  };
  for (int k = 0; k <= 40; ++k) look(std::log(kRateLow) + k / 40.0 * std::log(kRateHigh / kRateLow));
  for (double step = 0.13; step > 1e-5; step *= 0.5) {
    const double from = centre;
    look(from - step);
    look(from + step);
  }
  return std::exp(centre);
}

/// By the steps of Gauss and Newton of everything together, from a pace on; each at most doubles or halves the rate.
ThermalPace descended(const Recordings& recordings, ThermalPace from, double variance) {
  constexpr int kSteps = 40, kHalvings = 8;
  constexpr double kSettled = 1e-10, kFactor = 2.0;
  ThermalSolution at = solve_thermal(recordings, from, variance);
  for (int step = 0; step < kSteps && at.found(); ++step) {
    const ThermalNormal normal = thermal_normal(recordings, from, at, variance);
    const Eigen::VectorXd move = solve_scaled(normal.matrix, normal.right);
    const double rate = move(at.x.size()), lag = move(at.x.size() + 1), before = at.cost;
    for (int halving = 0; halving < kHalvings; ++halving) {
      const double share = std::pow(0.5, halving);
      const ThermalPace next{std::clamp(from.rate_per_s + share * rate, std::max(kRateLow, from.rate_per_s / kFactor),
                                        std::min(kRateHigh, from.rate_per_s * kFactor)),
                             std::clamp(from.lag_s + share * lag, 0.0, kLongestLag)};
      const ThermalSolution there = solve_thermal(recordings, next, variance);
      if (there.cost >= at.cost) continue;
      at = there;
      from = next;
      break;
    }
    if (at.cost >= before * (1.0 - kSettled)) break;
  }
  return from;
}

/// Beginning at a rate without a lag.
ThermalPace best_pace(const Recordings& recordings, double rate, double variance) {
  ThermalPace out{rate, 0.0};
  double best = solve_thermal(recordings, out, variance).cost;
  for (const double lag_s : {0.0, 30.0, 200.0}) {
    const ThermalPace pace = descended(recordings, {rate, lag_s}, variance);
    const double cost = solve_thermal(recordings, pace, variance).cost;
    if (cost >= best) continue;
    best = cost;
    out = pace;
  }
  return out;
}

/// Of the residuals that the best model without what is assumed would leave: first as noise alone.
double first_variance(const Recordings& recordings) {
  double seconds = 0.0, rows = 0.0;
  for (const ThermalRecording& r : recordings) {
    for (const double dt : r.dt_s) seconds += dt;
    rows += static_cast<double>(r.rows());
  }
  VOLTLAP_DEMAND(rows > 0.0);
  return kLeastNoise_k * kLeastNoise_k * std::max(seconds / rows, 1e-3);
}

/// The model without a lag, its intervals as wide as to hold those of the one with the lag: there may be one.
ThermalModel covering(ThermalModel without, const ThermalModel& with) {
  const auto widened = [](double value, double half_width, double other, double other_half_width) {
    return std::max(half_width, std::abs(value - other) + other_half_width);
  };
  const double c = without.capacity_j_per_k, g = without.conductance_w_per_k;
  without.capacity_ci95 = widened(c, c * without.capacity_ci95, with.capacity_j_per_k,
                                  with.capacity_j_per_k * with.capacity_ci95) / c;
  without.conductance_ci95 = widened(g, g * without.conductance_ci95, with.conductance_w_per_k,
                                     with.conductance_w_per_k * with.conductance_ci95) / g;
  without.entropy_ci95_v_per_k = widened(without.entropy_v_per_k, without.entropy_ci95_v_per_k, with.entropy_v_per_k,
                                         with.entropy_ci95_v_per_k);
  without.surface_lag_ci95_s = std::min(
      kLongestLag, widened(0.0, without.surface_lag_ci95_s, with.surface_lag_s, with.surface_lag_ci95_s));
  for (ThermalClass& one : without.classes) {
    for (const ThermalClass& other : with.classes) {
      if (one.number == other.number && one.other == other.other)
        one.ci95 = widened(one.value, one.ci95, other.value, other.ci95);
    }
  }
  judge_told(without);
  return without;
}

}  // namespace

ThermalModel fit_thermal(const Recordings& recordings) {
  require_rise(recordings);
  const double least = first_variance(recordings);
  double variance = least, rate = best_rate(recordings, variance);
  if (!solve_thermal(recordings, {rate, 0.0}, variance).found()) {
    throw InputError(recordings.front().file, "a cell that cools under load",
                     "a temperature that rises with the heat",
                     "Check the temperature's column and the sign of the current");
  }
  const Eigen::Index parameters = ThermalLayout(recordings).columns() + 2;
  const auto variance_at = [&](const ThermalPace& pace) {
    return std::max(least, residual_variance(solve_thermal(recordings, pace, variance).residual, parameters));
  };
  // What is assumed weighs by the noise, and the noise is known when the rest is fitted.
  variance = variance_at(best_pace(recordings, rate, variance));
  rate = best_rate(recordings, variance);
  const ThermalPace pace = best_pace(recordings, rate, variance);
  variance = variance_at(pace);
  const auto model_at = [&](const ThermalPace& at) {
    return told_model(recordings, at, solve_thermal(recordings, at, variance), variance);
  };
  const ThermalModel model = model_at(pace);
  if (model.surface_lag_s > model.surface_lag_ci95_s) return model;
  return covering(model_at({rate, 0.0}), model);
}

}  // namespace voltlap::plant
