// SPDX-License-Identifier: Apache-2.0
#include "discrepancy/anonymous_shapes.hpp"

#include <fmt/format.h>

#include <cmath>

namespace voltlap::plant {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::VectorXd;

class Shapes {
 public:
  Shapes(const Design& design, std::size_t channel)
      : channel_(channel), time_(design.comparison.log.time_s), channels_(design.comparison.channels.size()),
        balance_(design.comparison.channels[channel].balance),
        size_(usual_size(design.comparison.channels[channel], design.model.car.battery.cells_in_series)),
        name_(design.comparison.channels[channel].name) {}

  void add(const std::string& what, VectorXd values) {
    double square = 0.0, count = 0.0;
    for (double& v : values) {
      if (!std::isfinite(v)) v = 0.0;
      square += v * v;
      count += 1.0;
    }
    if (square <= 0.0) return;
    Column column{-1, 0, 0, fmt::format("anonymous/{}/{}", name_, what), balance_, std::vector<VectorXd>(channels_)};
    column.effect[channel_] = values * (size_ / std::sqrt(square / count));
    out.push_back(std::move(column));
  }
  void add_lagged(const std::string& what, const VectorXd& values, std::initializer_list<double> taus) {
    for (const double tau : taus) add(fmt::format("{} behind {} s", what, tau), lagged(time_, values, tau));
  }
  /// Mean-free powers over the range of `x`.
  void add_powers(const std::string& what, const VectorXd& x, int highest) {
    const double middle = 0.5 * (x.minCoeff() + x.maxCoeff()), half = 0.5 * (x.maxCoeff() - x.minCoeff());
    if (half <= 0.0) return;
    for (int power = 1; power <= highest; ++power) {
      add(fmt::format("{}^{}", what, power), ((x.array() - middle) / half).pow(power).matrix());
    }
  }
  std::vector<Column> out;

 private:
  std::size_t channel_;
  VectorXd time_;
  std::size_t channels_;
  Balance balance_;
  double size_;
  std::string name_;
};

void voltage_shapes(const Design& design, Shapes& shapes) {
  const BatteryResponse& b = design.base.battery;
  const ArrayXd current = b.current_a.array();
  const VectorXd time = design.comparison.log.time_s;
  shapes.add("1", VectorXd::Ones(time.size()));
  shapes.add_powers("time", time, 2);
  shapes.add_powers("soc", b.soc, 5);
  shapes.add("current", b.current_a);
  shapes.add("|current|", current.abs().matrix());
  shapes.add("current |current|", (current * current.abs()).matrix());
  shapes.add("current soc", (current * b.soc.array()).matrix());
  shapes.add("current soc^2", (current * b.soc.array().square()).matrix());
  shapes.add("current temperature", (current * (b.temperature_c.array() - b.temperature_c(0))).matrix());
  shapes.add_lagged("current", b.current_a, {0.5, 2.0, 6.0, 20.0, 60.0, 200.0, 600.0, 2000.0});
  shapes.add_lagged("direction", current.sign().matrix(), {30.0, 300.0});
  shapes.add_lagged("|current|", current.abs().matrix(), {60.0});
}

void heat_shapes(const Design& design, Shapes& shapes) {
  const BatteryResponse& b = design.base.battery;
  const VectorXd time = design.comparison.log.time_s;
  const VectorXd heat = b.drop_v.cwiseProduct(b.current_a);
  VectorXd stopped(time.size());
  for (Index row = 0; row < time.size(); ++row) stopped(row) = design.comparison.facts.stopped[static_cast<std::size_t>(row)];
  shapes.add("1", VectorXd::Ones(time.size()));
  shapes.add_powers("time", time, 2);
  shapes.add_lagged("heat", heat, {10.0, 40.0, 150.0, 600.0, 2400.0});
  shapes.add_lagged("current", b.current_a, {40.0, 600.0, 2400.0});
  shapes.add_lagged("stop", stopped, {300.0, 2400.0});
  shapes.add("rise", (b.temperature_c.array() - b.temperature_c(0)).matrix());
}

void terminal_shapes(const Design& design, const VectorXd& volts, Shapes& shapes) {
  const BatteryResponse& b = design.base.battery;
  const VectorXd time = design.comparison.log.time_s;
  shapes.add("1", VectorXd::Ones(time.size()));
  shapes.add_powers("time", time, 1);
  shapes.add("voltage", volts);
  shapes.add("current", b.current_a);
  shapes.add("|current|", b.current_a.cwiseAbs());
  shapes.add("current step", shifted(time, b.current_a, 0.05) - shifted(time, b.current_a, -0.05));
  shapes.add_lagged("current", b.current_a, {10.0, 300.0});
}

void car_shapes(const Design& design, Shapes& shapes) {
  const Recording& log = design.comparison.log;
  const VectorXd time = log.time_s;
  shapes.add("1", VectorXd::Ones(time.size()));
  shapes.add_powers("time", time, 1);
  const auto signal = [&](const char* role) {
    const VectorXd* found = log.find(role);
    return found != nullptr ? *found : VectorXd();
  };
  const VectorXd torque = signal("motor_torque"), motor = signal("motor_speed"), speed = signal("speed");
  for (const auto& [name, values] : {std::pair{"torque", torque}, {"motor speed", motor}, {"speed", speed},
                                     {"brake", signal("brake")}, {"accelerator", signal("accelerator")}}) {
    if (values.size() == 0) continue;
    shapes.add(name, values);
    shapes.add(fmt::format("{}^2", name), values.cwiseAbs2());
    shapes.add(fmt::format("{} time", name), values.cwiseProduct((time.array() - time(0)).matrix()));
  }
  if (torque.size() > 0 && motor.size() > 0) {
    shapes.add("torque motor speed", torque.cwiseProduct(motor));
    shapes.add("|torque| motor speed", torque.cwiseAbs().cwiseProduct(motor));
  }
}

}  // namespace

double usual_size(const BalanceChannel& channel, double cells_in_series) {
  if (channel.name == "power") return 300.0;
  if (channel.name == "speed") return 0.2;
  if (channel.name == "motor_speed") return 30.0;
  if (channel.balance == Balance::kHeat) return 1.0;
  return channel.name == "voltage" ? 5e-3 : 2e-3 * cells_in_series;
}

std::vector<Column> anonymous_columns(const Design& design) {
  std::vector<Column> out;
  for (std::size_t c = 0; c < design.comparison.channels.size(); ++c) {
    const BalanceChannel& channel = design.comparison.channels[c];
    Shapes shapes(design, c);
    if (c == 0) {
      voltage_shapes(design, shapes);
    } else if (channel.balance == Balance::kVoltage) {
      terminal_shapes(design, design.base.channels[c], shapes);
    } else if (channel.balance == Balance::kHeat) {
      heat_shapes(design, shapes);
    } else {
      car_shapes(design, shapes);
    }
    for (Column& column : shapes.out) out.push_back(std::move(column));
  }
  return out;
}

}  // namespace voltlap::plant
