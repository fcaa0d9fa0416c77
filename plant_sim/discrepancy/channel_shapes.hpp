// SPDX-License-Identifier: Apache-2.0
// Collects the shapes without a name of one channel.
#pragma once
#include <fmt/format.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "discrepancy/anonymous_shapes.hpp"
#include "discrepancy/battery_response.hpp"
#include "discrepancy/design.hpp"

namespace voltlap::plant {

/// What a sound model usually misses of the shapes of one kind, and what of that changes from log to log; in the
/// channel's usual size. The references correct both.
struct Kin {
  std::size_t number;
  double usual, repeats;
};

class Shapes {
 public:
  Shapes(const Design& design, std::size_t channel)
      : channel_(channel), time_(design.comparison.log.time_s), channels_(design.comparison.channels.size()),
        balance_(design.comparison.channels[channel].balance),
        size_(usual_size(design.comparison.channels[channel], design.model.car.battery.cells_in_series)),
        name_(design.comparison.channels[channel].name) {}

  [[nodiscard]] double size() const { return size_; }
  /// `values` in numbers that mean the same in every log; 1 is a usual size.
  void add(const Kin& kin, const std::string& what, Eigen::VectorXd values) {
    for (double& v : values) {
      if (!std::isfinite(v)) v = 0.0;
    }
    if (values.cwiseAbs().maxCoeff() < 1e-9) return;
    Column column;
    column.key = fmt::format("anonymous/{}/{}", name_, what);
    column.balance = balance_;
    column.effect.resize(channels_);
    column.effect[channel_] = values * size_;
    column.kin = kin.number;
    column.usual = kin.usual;
    column.repeats = kin.repeats;
    out.push_back(std::move(column));
  }
  /// The same, where this log tells how large it is: errors of other logs along it do not bound it.
  void add_of_start(const Kin& kin, const std::string& what, Eigen::VectorXd values) {
    const std::size_t before = out.size();
    add(kin, what, std::move(values));
    if (out.size() > before) out.back().of_start = true;
  }
  [[nodiscard]] Eigen::VectorXd behind(const Eigen::VectorXd& values, double tau_s) const {
    return lagged(time_, values, tau_s);
  }
  [[nodiscard]] const Eigen::VectorXd& time() const { return time_; }
  std::vector<Column> out;

 private:
  std::size_t channel_;
  Eigen::VectorXd time_;
  std::size_t channels_;
  Balance balance_;
  double size_;
  std::string name_;
};

[[nodiscard]] inline Eigen::VectorXd times(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  return a.cwiseProduct(b);
}

}  // namespace voltlap::plant
