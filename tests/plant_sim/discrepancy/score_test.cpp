// SPDX-License-Identifier: Apache-2.0
// Noise of what is left in a channel, where the sensors behind it tell how they wander.
#include "discrepancy/score.hpp"

#include <cmath>
#include <random>

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using Eigen::Index;
using Eigen::VectorXd;

/// Four sensors of one kind that wander with 30 s, on cells whose mean differs from the model's by what it misses slowly:
/// thermistors, or the taps of a voltage at a hundredth of their sizes.
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

  /// A model that has the shape of what it misses among its usual errors, by a share of its size; none at 0.
  double follows = 0.0;
  Balance kind = Balance::kHeat;

  Design drive(double missed_k, bool members) {
    const bool heat = kind == Balance::kHeat;
    const double scale = heat ? 1.0 : 1e-2;
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
      all.push_back(scale * reading());
      mean += all.back() / 4.0;
    }
    const VectorXd shape_missed = scale * (on.log.time_s.array() / 100.0).sin();
    const VectorXd told = mean + missed_k * shape_missed, other = (heat ? 1e-2 : 1.0) * reading();
    out.residual = heat ? std::vector<VectorXd>{other, told} : std::vector<VectorXd>{told, other};
    Column level;
    level.effect = {VectorXd::Ones(kRows), VectorXd::Ones(kRows)};
    level.usual = level.repeats = 0.01;
    out.columns.push_back(level);
    if (follows > 0.0) {
      Column missed;
      missed.effect = {heat ? VectorXd() : shape_missed, heat ? shape_missed : VectorXd()};
      missed.usual = missed.repeats = follows;
      missed.kin = 1;
      out.columns.push_back(missed);
    }
    if (!members) return out;
    Group group{heat ? "temperature_" : "cell_voltage_", kind, {}, {}};
    for (const VectorXd& one : all) {
      group.members.push_back(group.stem + std::to_string(group.members.size() + 1));
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
    const bool heat = kind == Balance::kHeat;
    const Noise found = noise_of({&a, &b, &c}).at(heat ? "temperature" : "voltage");
    const double wander = heat ? kWander : 1e-2 * kWander;
    return found.coloured * found.coloured * found.tau_s / (wander * wander / 4.0 * kMemory);
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

TEST(Score, TheMeanOfCellVoltagesWandersNoSlowerThanTheirTapsDo) {
  kind = Balance::kVoltage;
  CHECK(louder(0.3, false) > 100.0);
  CHECK(louder(0.3, true) < 30.0);
}

TEST(Score, WhatTheUsualErrorsCanFollowIsNoWanderEvenWithoutSensorsThatTellIt) {
  follows = 0.1;
  CHECK(louder(0.3, false) < 10.0);
}
