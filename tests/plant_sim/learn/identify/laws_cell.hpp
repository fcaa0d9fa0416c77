// SPDX-License-Identifier: Apache-2.0
// A cell with laws over temperature and current whose truth is known, drawn or given, integrated in small steps by its
// differential equation: shares no code with the fits.
#pragma once
#include <cmath>
#include <random>
#include <vector>

#include "io/logs/cell_log.hpp"

struct LawsCell {
  double capacity_ah = 5.0;
  double r0_ohm = 8e-3, r1_ohm = 6e-3, r2_ohm = 6e-3, tau1_s = 10.0, tau2_s = 250.0;  ///< at 25 degC
  double ohmic_kj = 18.0, r1_kj = 30.0, r2_kj = 30.0, tau1_kj = 25.0, tau2_kj = 20.0;  ///< kJ/mol
  double exchange_a = 0.0;  ///< at 25 degC; 0: no charge transfer besides R0
  double entropy_mv_per_k = 0.0, noise_v = 3e-4;
  unsigned seed = 1;

  static double em(double s) { return 3.1 + 1.6 * s - 1.5 * s * s + 1.0 * s * s * s - 0.25 * std::exp(-18.0 * s); }

  /// One of many chemistries and sizes.
  static LawsCell draw(std::mt19937& from) {
    const auto uniform = [&](double low, double high) { return std::uniform_real_distribution(low, high)(from); };
    constexpr double kThermal_v = 8.314462618 * 298.15 / 96485.33212;
    LawsCell cell;
    cell.capacity_ah = std::exp(uniform(std::log(1.5), std::log(60.0)));
    cell.r0_ohm = uniform(0.02, 0.06) / cell.capacity_ah;
    cell.r1_ohm = uniform(0.4, 1.2) * cell.r0_ohm;
    cell.r2_ohm = uniform(0.4, 1.2) * cell.r0_ohm;
    cell.tau1_s = uniform(5.0, 20.0);
    cell.tau2_s = uniform(150.0, 350.0);
    cell.ohmic_kj = uniform(8.0, 30.0);
    cell.r1_kj = uniform(12.0, 35.0);
    cell.r2_kj = uniform(12.0, 35.0);
    cell.tau1_kj = cell.r1_kj + uniform(-15.0, 10.0);
    cell.tau2_kj = cell.r2_kj + uniform(-15.0, 10.0);
    cell.exchange_a = 2.0 * kThermal_v / (uniform(0.3, 0.8) * cell.r0_ohm);
    cell.entropy_mv_per_k = uniform(-0.2, 0.2);
    cell.seed = static_cast<unsigned>(from());
    return cell;
  }

  /// One row a second, each with the current that has held since the one before.
  [[nodiscard]] voltlap::plant::CellLog record(const std::vector<double>& current_a, double at_c,
                                               double start_soc = 1.0) const {
    constexpr int kSteps = 20;
    constexpr double kGas = 8.314462618e-3, kFaraday = 96.48533212;  // kJ/mol/K, kC/mol
    const double kelvin = at_c + 273.15, x = (1.0 / kelvin - 1.0 / 298.15) / kGas;
    const double branch1 = std::exp(r1_kj * x), branch2 = std::exp(r2_kj * x);
    const double slow1 = std::exp(tau1_kj * x), slow2 = std::exp(tau2_kj * x);
    voltlap::plant::CellLog log;
    log.path = "laws cell";
    std::mt19937 generator(seed + static_cast<unsigned>(1000.0 * (at_c + 100.0)));
    std::normal_distribution<double> noise(0.0, 1.0);
    double soc = start_soc, v1 = 0.0, v2 = 0.0;
    for (std::size_t row = 0; row < current_a.size(); ++row) {
      const double i = current_a[row];
      for (int k = 0; row > 0 && k < kSteps; ++k) {
        const double h = 1.0 / kSteps;
        soc -= i * h / (3600.0 * capacity_ah);
        v1 += (r1_ohm * branch1 * i - v1) * (1.0 - std::exp(-h / (tau1_s * slow1)));
        v2 += (r2_ohm * branch2 * i - v2) * (1.0 - std::exp(-h / (tau2_s * slow2)));
      }
      double drop = r0_ohm * std::exp(ohmic_kj * x) * i + v1 + v2;
      if (exchange_a > 0.0) drop += 4.0 * kGas * kelvin / kFaraday * std::asinh(0.5 * i / exchange_a * branch1);
      log.time_s.push_back(static_cast<double>(row));
      log.current_a.push_back(i);
      log.voltage_v.push_back(em(soc) + 1e-3 * entropy_mv_per_k * (at_c - 25.0) - drop + noise_v * noise(generator));
      log.temperature_c.push_back(at_c);
    }
    log.gap.assign(log.rows(), false);
    return log;
  }

  /// Pulses of a tenth of the capacity, at the rates in turn, with rests of ten minutes.
  [[nodiscard]] std::vector<double> pulses(const std::vector<double>& rates) const {
    constexpr double kStep = 0.1, kEnd = 0.05;
    std::vector<double> plan(300, 0.0);
    std::size_t turn = 0;
    for (double soc = 1.0; soc - kStep > kEnd; soc -= kStep, ++turn) {
      const double rate = rates[turn % rates.size()];
      plan.insert(plan.end(), static_cast<std::size_t>(std::lround(kStep * 3600.0 / rate)), rate * capacity_ah);
      plan.insert(plan.end(), 600, 0.0);
    }
    return plan;
  }
};
