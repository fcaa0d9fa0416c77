// SPDX-License-Identifier: Apache-2.0
// A cell whose truth is known, integrated in small steps by its differential equation: shares no code with the
// fits. Its OCV is a smooth curve; its circuit is straight between the plant's breakpoints.
#pragma once
#include <cmath>
#include <random>
#include <vector>

#include "io/logs/cell_log.hpp"

/// Truth as smooth curves over SOC.
struct KnownCell {
  double capacity_ah = 30.0;
  double noise_v = 0.0, step_v = 0.0, row_s = 1.0;
  double third_ohm = 0.0, third_tau_s = 2.5;  ///< of a branch more, the same for all SOC
  unsigned seed = 1;

  static double em(double s) {
    return 3.0 + 1.6 * s - 1.5 * s * s + 1.05 * s * s * s + 0.25 * (1.0 - std::exp(-18.0 * s)) - 0.25;
  }
  static double r0(double s) {
    return straight(s, [](double x) { return 1.4e-3 * (1.0 + 0.6 * std::exp(-8.0 * x)); });
  }
  static double r1(double s) {
    return straight(s, [](double x) { return 0.9e-3 * (1.0 + 0.5 * std::exp(-6.0 * x) + 0.1 * x); });
  }
  static double r2(double s) {
    return straight(s, [](double x) { return 1.3e-3 * (1.0 + 0.8 * std::exp(-7.0 * x)); });
  }
  static double tau1(double s) { return 18.0 + 6.0 * s; }
  static double tau2(double s) { return 300.0 - 120.0 * s; }

  template <class Curve>
  static double straight(double s, const Curve& curve) {
    constexpr double kAt[] = {0.001, 0.05, 0.1, 0.15, 0.2,  0.25, 0.3,  0.4,
                              0.5,   0.6,  0.7, 0.8,  0.85, 0.9,  0.95, 1.0};
    if (s <= kAt[0]) return curve(kAt[0]);
    for (int k = 1; k < 16; ++k) {
      if (s <= kAt[k])
        return curve(kAt[k - 1]) + (curve(kAt[k]) - curve(kAt[k - 1])) * (s - kAt[k - 1]) / (kAt[k] - kAt[k - 1]);
    }
    return curve(1.0);
  }

  /// What a tester records of a plan: one row an entry, each with the current that has held since the one before.
  [[nodiscard]] voltlap::plant::CellLog record(const std::vector<double>& current_a, double start_soc = 1.0) const {
    constexpr int kSteps = 20;
    voltlap::plant::CellLog log;
    log.path = "known cell";
    std::mt19937 generator(seed);
    std::normal_distribution<double> noise(0.0, 1.0);
    double soc = start_soc, v1 = 0.0, v2 = 0.0, v3 = 0.0;
    for (std::size_t row = 0; row < current_a.size(); ++row) {
      const double i = current_a[row];
      if (row > 0) {
        const double h = row_s / kSteps;
        for (int k = 0; k < kSteps; ++k) {
          soc -= i * h / (3600.0 * capacity_ah);
          const auto slope1 = [&](double v) { return (r1(soc) * i - v) / tau1(soc); };
          const auto slope2 = [&](double v) { return (r2(soc) * i - v) / tau2(soc); };
          v1 += h * slope1(v1 + 0.5 * h * slope1(v1));
          v2 += h * slope2(v2 + 0.5 * h * slope2(v2));
          const auto slope3 = [&](double v) { return (third_ohm * i - v) / third_tau_s; };
          v3 += h * slope3(v3 + 0.5 * h * slope3(v3));
        }
      }
      double v = em(soc) - r0(soc) * i - v1 - v2 - v3 + noise_v * noise(generator);
      if (step_v > 0.0) v = step_v * std::round(v / step_v);
      log.time_s.push_back(row_s * static_cast<double>(row));
      log.current_a.push_back(i);
      log.voltage_v.push_back(v);
    }
    log.gap.assign(log.rows(), false);
    return log;
  }

  /// Pulses of 5 % above 80 and below 20 % SOC and 10 % between, at one current, with rests between.
  [[nodiscard]] std::vector<double> pulse_plan(double current_a, int rest_s, double end_soc = 0.02) const {
    std::vector<double> plan(300, 0.0);
    for (double soc = 1.0; soc > end_soc + 1e-9;) {
      const double step = std::min(soc - end_soc, soc > 0.8 + 1e-9 || soc < 0.2 + 1e-9 ? 0.05 : 0.1);
      plan.insert(plan.end(), static_cast<std::size_t>(std::lround(step * capacity_ah * 3600.0 / current_a)),
                  current_a);
      plan.insert(plan.end(), static_cast<std::size_t>(rest_s), 0.0);
      soc -= step;
    }
    return plan;
  }
};
