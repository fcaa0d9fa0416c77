// SPDX-License-Identifier: Apache-2.0
// Columns of a family as they are collected, and what is made of them.
#pragma once
#include <string>
#include <vector>

#include "explain/fit/columns.hpp"

namespace voltlap::explain {

inline constexpr double kStep = 0.1;   // of a typical size: derivative
inline constexpr double kWide = 30.0;  // typical sizes: nothing is known of a cause beforehand

/// Columns as they are collected: effects by channel.
struct Collected {
  std::vector<std::vector<VectorXd>> effect;  ///< [column][channel]
  std::vector<double> sigma, typical;
  std::vector<Curve> curves;
  /// What was added last as the points of a form's curve.
  void put_curve(const plant::Form& form, const std::vector<Index>& points) {
    if (form.bend <= 0.0 || points.empty()) return;
    curves.push_back({points.front(), static_cast<Index>(points.size()), form.bend / typical.back()});
  }
  Index add(std::vector<VectorXd> by_channel, double prior_sigma, double unit) {
    effect.push_back(std::move(by_channel));
    sigma.push_back(prior_sigma);
    typical.push_back(unit);
    return static_cast<Index>(effect.size()) - 1;
  }
};

/// Noise that no hypothesis is allowed to be below: what is smaller decides nothing.
[[nodiscard]] double least_noise(const ReadChannel& channel);

/// Which noises are tried.
enum class Noises { kAll, kWhite };

[[nodiscard]] Problem problem_of(const std::vector<const ReadChannel*>& channels, const Observed& log,
                                 const Collected& columns, const std::vector<Index>& nuisances,
                                 Noises noises = Noises::kAll);

/// Names, practical sizes and units of what was collected.
void describe(const std::vector<const ReadChannel*>& channels, const Collected& columns, Family& out);

}  // namespace voltlap::explain
