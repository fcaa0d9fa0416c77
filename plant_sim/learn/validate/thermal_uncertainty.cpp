// SPDX-License-Identifier: Apache-2.0
#include "learn/validate/thermal_uncertainty.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/demand.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;

constexpr double kWide = 1.96;  // sigmas of 95 %
// Wider than this a number tells less than what is known of any cell: lithium-ion cells have 700 to 1300 J/kg/K, a cell
// in still to moving air 5 to 15 W/m2/K, and of dOCV/dT the data must take half of what was assumed.
constexpr double kToldCapacity = 0.3, kToldConductance = 0.5, kToldEntropy = 0.5;
// Two numbers go together beyond this correlation: alone the interval is 2.3 times that with the other known.
constexpr double kTogether = 0.9, kWorthSaying = 0.1;  // of the number itself

/// A number of the result: its value, and how it changes with what was fitted.
struct Number {
  std::string name, unit;
  double value;
  Eigen::VectorXd slope;
};

class Numbers {
 public:
  Numbers(Eigen::MatrixXd covariance, std::vector<Number> all)
      : covariance_(std::move(covariance)), all_(std::move(all)) {}
  [[nodiscard]] std::size_t size() const { return all_.size(); }
  [[nodiscard]] const Number& at(std::size_t k) const { return all_[k]; }
  [[nodiscard]] double with(std::size_t a, std::size_t b) const {
    return all_[a].slope.dot(covariance_ * all_[b].slope);
  }
  [[nodiscard]] double half_width(std::size_t k) const { return kWide * std::sqrt(std::max(0.0, with(k, k))); }
  /// Empty unless the first is wide and goes together with the second. `at`: where the second is taken.
  [[nodiscard]] std::optional<ThermalClass> together(std::size_t a, std::size_t b, double at) const {
    const double both = with(a, b), of_b = with(b, b);
    const double correlation = both / std::sqrt(with(a, a) * of_b);
    if (!(std::abs(correlation) > kTogether) || half_width(a) < kWorthSaying * std::abs(all_[a].value))
      return std::nullopt;
    const double slope = both / of_b;
    return ThermalClass{all_[a].name, all_[a].unit, all_[a].value + slope * (at - all_[b].value),
                        half_width(a) * std::sqrt(std::max(0.0, 1.0 - correlation * correlation)),
                        all_[b].name, all_[b].unit, at, slope};
  }

 private:
  Eigen::MatrixXd covariance_;
  std::vector<Number> all_;
};

constexpr std::size_t kCapacity = 0, kConductance = 1, kEntropy = 2, kLag = 3, kFirstAir = 4;

Numbers numbers_of(const std::vector<ThermalRecording>& recordings, const ThermalPace& pace,
                   const ThermalSolution& solution, double variance) {
  const Eigen::VectorXd& x = solution.x;
  const Index n = x.size() + 2;
  const auto none = [&] { return Eigen::VectorXd(Eigen::VectorXd::Zero(n)); };
  const double capacity = 1.0 / x(0), entropy = x(1) / x(0);
  Number c{"heat capacity", "J/K", capacity, none()}, g{"cooling", "W/K", pace.rate_per_s * capacity, none()},
      e{"dOCV/dT", "V/K", entropy, none()}, lag{"lag of the surface", "s", pace.lag_s, none()};
  c.slope(0) = -capacity * capacity;
  g.slope(0) = pace.rate_per_s * c.slope(0);
  g.slope(x.size()) = capacity;
  e.slope(0) = -entropy * capacity;
  e.slope(1) = capacity;
  lag.slope(x.size() + 1) = 1.0;
  std::vector<Number> all{c, g, e, lag};
  const ThermalLayout layout(recordings);
  for (std::size_t k = 0; k < recordings.size(); ++k) {
    if (!layout.air(k)) continue;
    Number air{recordings.size() == 1 ? "air" : fmt::format("air of {}", recordings[k].file), "degC",
               recordings[k].start_c() + x(*layout.air(k)), none()};
    air.slope(*layout.air(k)) = 1.0;
    all.push_back(air);
  }
  const Eigen::MatrixXd information = thermal_normal(recordings, pace, solution, variance).matrix;
  return {solve_scaled(information, Eigen::MatrixXd::Identity(n, n)), std::move(all)};
}

void add_classes(const Numbers& numbers, ThermalModel& model) {
  const auto add = [&](std::size_t a, std::size_t b, double at) {
    if (auto found = numbers.together(a, b, at)) model.classes.push_back(*found);
  };
  add(kCapacity, kEntropy, 0.0);
  add(kConductance, kEntropy, 0.0);
  // Where both go with the entropy they go with each other, and that is said already.
  if (model.classes.empty()) add(kCapacity, kConductance, numbers.at(kConductance).value);
  for (std::size_t k = kFirstAir; k < numbers.size(); ++k) {
    add(kCapacity, k, numbers.at(k).value);
    add(kConductance, k, numbers.at(k).value);
  }
}

}  // namespace

double residual_variance(const Eigen::VectorXd& residual, Index parameters) {
  VOLTLAP_DEMAND(residual.size() > 1);
  double with = 0.0;
  for (Index row = 1; row < residual.size(); ++row) with += residual(row) * residual(row - 1);
  const double cost = residual.squaredNorm(), rows = static_cast<double>(residual.size());
  // At most so much alike that two rows' worth is left.
  const double r = cost > 0.0 ? std::clamp(with / cost, 0.0, 1.0 - 2.0 / rows) : 0.0;
  return cost / std::max(1.0, rows - static_cast<double>(parameters)) * (1.0 + r) / (1.0 - r);
}

void judge_told(ThermalModel& model) {
  model.capacity_told = model.capacity_ci95 <= kToldCapacity;
  model.conductance_told = model.conductance_ci95 <= kToldConductance;
  model.entropy_told = model.entropy_ci95_v_per_k <= kToldEntropy * kWide * kEntropySd_v_per_k;
}

ThermalModel told_model(const std::vector<ThermalRecording>& recordings, const ThermalPace& pace,
                        const ThermalSolution& solution, double variance) {
  VOLTLAP_DEMAND(solution.found());
  const Numbers numbers = numbers_of(recordings, pace, solution, variance);
  ThermalModel out;
  out.capacity_j_per_k = numbers.at(kCapacity).value;
  out.conductance_w_per_k = numbers.at(kConductance).value;
  out.surface_lag_s = pace.lag_s;
  out.entropy_v_per_k = numbers.at(kEntropy).value;
  out.capacity_ci95 = numbers.half_width(kCapacity) / out.capacity_j_per_k;
  out.conductance_ci95 = numbers.half_width(kConductance) / out.conductance_w_per_k;
  out.surface_lag_ci95_s = numbers.half_width(kLag);
  out.entropy_ci95_v_per_k = numbers.half_width(kEntropy);
  judge_told(out);
  std::size_t air = kFirstAir;
  for (const ThermalRecording& r : recordings) {
    const bool fitted = r.air != AirFrom::kLog;
    out.air_c.push_back(fitted ? numbers.at(air).value : r.ambient_c.front());
    out.air_ci95_k.push_back(fitted ? numbers.half_width(air) : 0.0);
    if (fitted) ++air;
  }
  add_classes(numbers, out);
  return out;
}

}  // namespace voltlap::plant
