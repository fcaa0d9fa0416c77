// SPDX-License-Identifier: Apache-2.0
// Collects the shapes without a name of one channel.
#pragma once
#include <fmt/format.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "explain/balances/battery_response.hpp"
#include "explain/shapes/anonymous_shapes.hpp"

namespace voltlap::plant {

class Shapes {
 public:
  Shapes(const Shown& shown, std::size_t channel)
      : channel_(channel),
        time_(shown.comparison.log.time_s),
        size_(usual_size(shown.comparison.channels[channel], shown.model.car.battery.cells_in_series)),
        name_(shown.comparison.channels[channel].name) {}

  [[nodiscard]] double size() const { return size_; }
  /// `values` in numbers that mean the same in every log; 1 is a usual size.
  void add(double usual, const std::string& what, Eigen::VectorXd values) {
    for (double& v : values) {
      if (!std::isfinite(v)) v = 0.0;
    }
    if (values.cwiseAbs().maxCoeff() < 1e-9) return;
    out.push_back({fmt::format("{}/{}", name_, what), channel_, usual, values * size_});
  }
  [[nodiscard]] Eigen::VectorXd behind(const Eigen::VectorXd& values, double tau_s) const {
    return lagged(time_, values, tau_s);
  }
  [[nodiscard]] const Eigen::VectorXd& time() const { return time_; }
  std::vector<Shape> out;

 private:
  std::size_t channel_;
  Eigen::VectorXd time_;
  double size_;
  std::string name_;
};

[[nodiscard]] inline Eigen::VectorXd times(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  return a.cwiseProduct(b);
}

}  // namespace voltlap::plant
