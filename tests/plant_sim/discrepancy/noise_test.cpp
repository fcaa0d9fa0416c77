// SPDX-License-Identifier: Apache-2.0
// Noise with known parts: they are found again, and what the whitener makes of it is white.
#include "discrepancy/noise.hpp"

#include <cmath>
#include <random>

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using Eigen::Index;
using Eigen::VectorXd;

TEST_GROUP(Noise) {
  VectorXd time = VectorXd::LinSpaced(12000, 0.0, 1200.0);
  std::mt19937_64 random{7};
  std::normal_distribution<double> normal;

  VectorXd drawn(const Noise& noise, const VectorXd& ohm) {
    VectorXd out(time.size());
    double slow = noise.coloured * normal(random);
    for (Index row = 0; row < time.size(); ++row) {
      if (row > 0) {
        const double keep = std::exp(-(time(row) - time(row - 1)) / noise.tau_s);
        slow = keep * slow + noise.coloured * std::sqrt(1.0 - keep * keep) * normal(random);
      }
      const double sensor = ohm.size() > 0 ? noise.current_a * ohm(row) : 0.0;
      out(row) = slow + std::hypot(noise.white, sensor) * normal(random);
    }
    return out;
  }

  std::vector<NoiseSample> several(const Noise& noise, int logs) {
    std::vector<NoiseSample> out;
    for (int k = 0; k < logs; ++k) out.push_back({&time, drawn(noise, VectorXd()), VectorXd()});
    return out;
  }
};

TEST(Noise, WhatTheWhitenerLeavesIsWhiteAndOfSizeOne) {
  const Noise noise{0.5, 0.6, 30.0, 0.0};
  const VectorXd white = Whitener(time, std::vector<bool>(12000, true), noise, VectorXd()).apply(drawn(noise, VectorXd()));
  DOUBLES_EQUAL(1.0, white.squaredNorm() / 12000.0, 0.05);                                 // standard error 0.013
  DOUBLES_EQUAL(0.0, white.head(11999).dot(white.tail(11999)) / white.squaredNorm(), 0.04);  // 0.009
}

TEST(Noise, WhiteAndSlowPartsAreFoundAgain) {
  const Noise noise{0.5, 0.6, 20.0, 0.0};
  const Noise found = fit_noise(several(noise, 24), 0.0, NoiseSearch::kBetween);
  DOUBLES_EQUAL(0.5, found.white, 0.01);
  DOUBLES_EQUAL(0.6, found.coloured, 0.06);
  DOUBLES_EQUAL(20.0, found.tau_s, 4.0);
}

TEST(Noise, ATimeBetweenThoseOfTheGridIsFoundAndNotALongerLouderOne) {
  // On the grid alone it is read as 300 s and much louder: many times the power of what is slow. One pass of the search
  // comes within 2.5 times.
  const Noise noise{0.05, 0.08, 60.0, 0.0};
  const Noise found = fit_noise(several(noise, 24), 0.0, NoiseSearch::kBetween);
  DOUBLES_EQUAL(0.05, found.white, 0.002);
  const double slow = found.coloured * found.coloured * found.tau_s;  // its density at the lowest frequencies
  DOUBLES_EQUAL(0.0, std::log(slow / (0.08 * 0.08 * 60.0)), std::log(2.5));
}

TEST(Noise, PartOfTheCurrentSensorIsFoundByTheResistanceThatChanges) {
  VectorXd cold = VectorXd::Constant(12000, 4e-3), warm = VectorXd::Constant(12000, 1e-3);
  const Noise noise{0.2e-3, 0.0, 20.0, 0.2};
  const Noise found = fit_noise({{&time, drawn(noise, cold), cold}, {&time, drawn(noise, warm), warm}}, 0.0, NoiseSearch::kBetween);
  DOUBLES_EQUAL(0.2, found.current_a, 0.02);
  CHECK(found.white < 0.3e-3);
}
