// SPDX-License-Identifier: Apache-2.0
// Minimum of a function of a few variables without derivatives: J. A. Nelder and R. Mead, Comput. J. 7 (1965) 308.
#pragma once
#include <Eigen/Dense>
#include <algorithm>
#include <utility>
#include <vector>

#include "core/demand.hpp"

namespace voltlap::plant {

/// Where `f` is least, from a simplex of edges `size` at `start`; ends when its points agree within 0.02 or after about
/// `evaluations` values of f.
template <class Function>
Eigen::VectorXd nelder_mead_minimum(const Function& f, const Eigen::VectorXd& start, double size, int evaluations) {
  using Eigen::Index;
  const Index n = start.size();
  VOLTLAP_DEMAND(n > 0 && start.allFinite() && size > 0.0);
  std::vector<std::pair<double, Eigen::VectorXd>> points{{f(start), start}};
  for (Index k = 0; k < n; ++k) {
    Eigen::VectorXd at = start;
    at(k) += size;
    points.emplace_back(f(at), at);
  }
  const auto by_value = [](const auto& a, const auto& b) { return a.first < b.first; };
  for (int used = static_cast<int>(n) + 1; used < evaluations;) {
    std::sort(points.begin(), points.end(), by_value);
    if ((points.back().second - points.front().second).cwiseAbs().maxCoeff() < 0.02) break;
    Eigen::VectorXd centre = Eigen::VectorXd::Zero(n);
    for (Index k = 0; k < n; ++k) centre += points[static_cast<std::size_t>(k)].second / static_cast<double>(n);
    auto& worst = points.back();
    const auto attempt = [&](double factor) {
      const Eigen::VectorXd at = centre + factor * (worst.second - centre);
      ++used;
      return std::pair{f(at), at};
    };
    const auto reflected = attempt(-1.0);
    if (reflected.first < points.front().first) {
      const auto further = attempt(-2.0);
      worst = further.first < reflected.first ? further : reflected;
    } else if (reflected.first < points[static_cast<std::size_t>(n) - 1].first) {
      worst = reflected;
    } else {
      const auto inner = attempt(reflected.first < worst.first ? -0.5 : 0.5);
      if (inner.first < std::min(worst.first, reflected.first)) {
        worst = inner;
        continue;
      }
      for (std::size_t k = 1; k < points.size(); ++k) {
        points[k].second = 0.5 * (points[k].second + points[0].second);
        points[k].first = f(points[k].second);
        ++used;
      }
    }
  }
  return std::min_element(points.begin(), points.end(), by_value)->second;
}

}  // namespace voltlap::plant
