// SPDX-License-Identifier: Apache-2.0
// Noise of what is left in a channel, where the sensors behind it tell how they wander.
#include "discrepancy/score.hpp"

#include <cmath>
#include <random>

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using Eigen::Index;
using Eigen::VectorXd;

/// Four thermistors that wander with 30 s, on cells whose mean differs from the model's by what it misses slowly.
TEST_GROUP(Score) {
  static constexpr Index kRows = 6000;  // 10 Hz
  static constexpr double kWander = 0.1, kWhite = 0.05, kMemory = 30.0;
  std::mt19937_64 random;
  std::normal_distribution<double> normal;

  VectorXd reading() {
    VectorXd out(kRows);
    const double keep = std::exp(-0.1 / kMemory);
    double slow = kWander * normal(random);
    for (double& v : out) {
      slow = keep * slow + kWander * std::sqrt(1.0 - keep * keep) * normal(random);
      v = slow + kWhite * normal(random);
    }
    return out;
  }

  Design drive(double missed_k, bool members) {
    Design out;
    Comparison& on = out.comparison;
    on.log.time_s = VectorXd::LinSpaced(kRows, 0.0, 0.1 * (kRows - 1));
    on.facts.at_rest.assign(kRows, false);
    out.base.battery.r0_ohm = VectorXd::Zero(kRows);
    out.model.car.battery.cells_in_series = out.model.car.battery.cells_in_parallel = 1;
    on.channels = {{"voltage", Balance::kVoltage, "V", {}}, {"temperature", Balance::kHeat, "K", {}}};
    std::vector<VectorXd> all;
    VectorXd mean = VectorXd::Zero(kRows);
    for (int k = 0; k < 4; ++k) {
      all.push_back(reading());
      mean += all.back() / 4.0;
    }
    const VectorXd missed = missed_k * (on.log.time_s.array() / 100.0).sin();
    out.residual = {1e-3 * reading(), mean + missed};
    Column level;
    level.effect = {VectorXd::Ones(kRows), VectorXd::Ones(kRows)};
    level.usual = level.repeats = 0.01;
    out.columns.push_back(level);
    if (!members) return out;
    Group group{"temperature_", Balance::kHeat, {}, {}};
    for (const VectorXd& one : all) {
      group.members.push_back("temperature_" + std::to_string(group.members.size() + 1));
      group.deviation.push_back(one - mean);
    }
    on.groups.push_back(group);
    Shape shape;
    shape.effect = VectorXd::Ones(kRows);
    out.shapes.push_back({shape});
    return out;
  }

  /// Density of the mean's slow noise at the lowest frequencies, over the sensors' own.
  double louder(double missed_k, bool members) {
    random.seed(3);
    const Design a = drive(missed_k, members), b = drive(-missed_k, members), c = drive(missed_k, members);
    const Noise found = noise_of({&a, &b, &c}).at("temperature");
    return found.coloured * found.coloured * found.tau_s / (kWander * kWander / 4.0 * kMemory);
  }
};

TEST(Score, WhatAModelMissesSlowlyIsNoWanderOfSensorsThatWanderFasterAgainstEachOther) {
  // With other seeds 168 to 196 times, and 6 to 25.
  CHECK(louder(0.3, false) > 100.0);
  CHECK(louder(0.3, true) < 30.0);
}

TEST(Score, WhereItMissesNothingTheWanderIsThatOfTheSensors) {
  const double times = louder(0.0, true);  // 0.9 to 3.2 with other seeds
  CHECK(times > 0.5);
  CHECK(times < 4.0);
}
