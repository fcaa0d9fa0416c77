// SPDX-License-Identifier: Apache-2.0
// Power density of what a fit leaves: of single rows, and of errors that last for hours.
#include <cmath>
#include <cstdlib>
#include <random>
#include <vector>

#include "learn/identify/fit/uncertainty.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(Uncertainty) {
  static constexpr int kRows = 60'000;
  static constexpr double kNoise_v = 1e-3;
  std::mt19937 draw;
  unsigned seed = 1;
  void setup() override {
    if (const char* given = std::getenv("VOLTLAP_TEST_SEED")) seed = static_cast<unsigned>(std::atoi(given));
    draw.seed(seed);
  }
  /// Seventeen hours, a row a second.
  static std::vector<MeasuredRun> long_test() {
    CellLog log;
    for (int row = 0; row < kRows; ++row) {
      log.time_s.push_back(row);
      log.current_a.push_back(1.0);
      log.voltage_v.push_back(3.7);
      log.temperature_c.push_back(25.0);
    }
    log.gap.assign(log.rows(), false);
    RunOptions options;
    options.capacity_ah = 20.0;
    return {make_run(log, options)};
  }
  /// Noise, and what changes once in `lasts_s` alone.
  std::vector<Eigen::VectorXd> errors(double lasting_v, int lasts_s) {
    std::normal_distribution<double> unit(0.0, 1.0);
    Eigen::VectorXd out(kRows);
    double level = 0.0;
    for (int row = 0; row < kRows; ++row) {
      if (row % lasts_s == 0) level = lasting_v * unit(draw);
      out(row) = level + kNoise_v * unit(draw);
    }
    return {out};
  }
};

TEST(Uncertainty, DensityOfNoiseIsThatOfItsRows) {
  const auto runs = long_test();
  const auto noise = errors(0.0, kRows);
  const double white = kNoise_v * kNoise_v;  // of rows of a second
  DOUBLES_EQUAL(white, noise_density(runs, noise), 0.3 * white);
  CHECK(lasting_density(runs, noise) >= noise_density(runs, noise));
  CHECK_TRUE_TEXT(lasting_density(runs, noise) < 4.0 * white, "blocks so few that they differ by chance");
}

TEST(Uncertainty, ErrorOfHoursIsNotTakenForManyIndependentOnes) {
  for (int k = 0; k < 10; ++k) {
    const int lasts_s = std::uniform_int_distribution<int>(1500, 6000)(draw);
    const double lasting_v = std::uniform_real_distribution<double>(1e-3, 5e-3)(draw);
    const auto runs = long_test();
    const auto left = errors(lasting_v, lasts_s);
    // What was drawn, not what it was drawn from: an hour's errors are few.
    const double square = std::max(0.0, left[0].squaredNorm() / kRows - kNoise_v * kNoise_v);
    const double ratio = lasting_density(runs, left) / (square * lasts_s);
    const double short_ratio = noise_density(runs, left) / (square * lasts_s);
    // Ten levels are few, and their square a third off by chance; blocks of minutes see a tenth of it.
    CHECK_TRUE_TEXT(ratio > 0.2 && ratio < 3.0 && short_ratio < 0.5 * ratio,
                    StringFromFormat("VOLTLAP_TEST_SEED=%u, draw %d: %.2f mV for %d s: %.2f, short %.2f", seed, k,
                                     1e3 * lasting_v, lasts_s, ratio, short_ratio).asCharString());
  }
}
