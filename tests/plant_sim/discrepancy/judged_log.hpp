// SPDX-License-Identifier: Apache-2.0
// A log of two channels with three columns, as it is when the verdict is made.
#pragma once
#include <cmath>
#include <optional>
#include <random>

#include <CppUTest/TestHarness.h>

#include "discrepancy/judged.hpp"

namespace voltlap::plant {

inline constexpr Eigen::Index kRows = 4800;  // 10 Hz, eight blocks of a minute
inline constexpr double kNoise = 1e-3;

inline Eigen::VectorXd noise(unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0.0, kNoise);
  Eigen::VectorXd out(kRows);
  for (double& v : out) v = normal(random);
  return out;
}

/// Cells' voltage and the pack's against them; candidate 0 acts on the first, candidate 1 on the second, candidate 2 is a
/// shape without a name that references know.
class JudgedLog : public Utest {
 public:
  std::vector<Cause> causes{2};
  Design design;
  std::vector<Candidate> locals;
  System system;
  NoiseModel known{{"voltage", {}}, {"pack_voltage", {}}};
  Usual usual;
  std::vector<bool> use;
  std::vector<WeighedSet> sets;
  Decision decision;
  Parts parts;
  std::optional<Refinery> refinery;
  Eigen::VectorXd wave;

  void setup() override {
    Comparison& on = design.comparison;
    on.log.time_s = Eigen::VectorXd::LinSpaced(kRows, 0.0, 0.1 * (kRows - 1));
    on.log.signals["current"] = Eigen::VectorXd::Ones(kRows);
    wave = (on.log.time_s.array() * 0.7).sin();
    const Eigen::VectorXd usually = (on.log.time_s.array() * 0.05).cos();
    on.channels = {{"voltage", Balance::kVoltage, "V", {}}, {"pack_voltage", Balance::kVoltage, "V", {}}};
    for (int k = 0; k < 3; ++k) {
      Column column;
      column.cause = k < 2 ? k : -1;
      column.effect.resize(2);
      column.effect[k == 1 ? 1 : 0] = k < 2 ? wave : usually;
      design.columns.push_back(column);
      Candidate candidate;
      candidate.cause = column.cause;
      candidate.rows = {k};
      system.candidates.push_back(candidate);
    }
    usual.mean = Eigen::VectorXd::Zero(3);
    system.prior_variance = Eigen::VectorXd::Ones(3);
  }

  /// The voltage's residual is these amounts of its columns; the pack's a little of its own.
  Judged judged_of(double amount, double usually) {
    design.residual = {noise(1) + amount * wave + usually * design.columns[2].effect[0], noise(2) + 1e-5 * wave};
    parts.quarters.assign(4, system);
    for (System& quarter : parts.quarters) quarter.information = Eigen::MatrixXd::Zero(3, 3), quarter.score = Eigen::VectorXd::Zero(3);
    for (Eigen::Index row = 0; row < kRows; ++row) {
      System& quarter = parts.quarters[static_cast<std::size_t>(row / 600 % 4)];
      for (int k = 0; k < 3; ++k) {
        const std::size_t c = k == 1 ? 1 : 0;
        const double x = design.columns[static_cast<std::size_t>(k)].effect[c](row);
        quarter.information(k, k) += x * x;
        quarter.score(k) += x * design.residual[c](row);
      }
    }
    system.information = Eigen::MatrixXd::Zero(3, 3);
    system.score = Eigen::VectorXd::Zero(3);
    for (const System& quarter : parts.quarters) system.information += quarter.information, system.score += quarter.score;
    usual.inflation = {1.0, 1.0};
    usual.variance = Eigen::MatrixXd::Zero(3, 3);
    refinery.emplace(design, causes, system, known, usual, std::vector<bool>(kRows, true));
    return {causes, design, locals, system, known, usual, use, sets, decision, parts, *refinery, nullptr};
  }
};

}  // namespace voltlap::plant
