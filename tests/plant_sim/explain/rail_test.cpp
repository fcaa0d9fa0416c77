// SPDX-License-Identifier: Apache-2.0
// A pile of readings at the end of a current.
#include "explain/gate/rail.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr Index kRows = 6000;                   // 10 Hz
constexpr double kLimit = 60.0, kNoise = 0.15;  // A

/// Pulls of 40 to 110 A, with rests between them.
VectorXd pulls(double sign) {
  VectorXd out(kRows);
  for (Index row = 0; row < kRows; ++row) {
    const double t = 0.1 * static_cast<double>(row);
    out(row) = t < 30.0 ? 0.0 : sign * std::max(0.0, (75.0 + 35.0 * std::sin(0.11 * t)) * std::sin(0.7 * t));
  }
  return out;
}

VectorXd clipped(VectorXd current) {
  for (double& i : current) i = std::clamp(i, -kLimit, kLimit);
  return current;
}

VectorXd with_noise(VectorXd values, double sigma) {
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0.0, sigma);
  for (double& v : values) v += noise(random);
  return values;
}

}  // namespace

TEST_GROUP(Rail){};

TEST(Rail, a_pile_of_noisy_readings_at_the_end_is_a_rail_and_the_peak_of_a_pull_is_none) {
  const VectorXd current = with_noise(clipped(pulls(1.0)), kNoise);
  const auto rail = rail_of(current);
  CHECK(rail.has_value());
  DOUBLES_EQUAL(kLimit, rail->limit_a, 0.05);
  DOUBLES_EQUAL(kNoise, rail->noise_a, 0.05);
  for (Index row = 0; row < kRows; ++row) {
    if (pulls(1.0)(row) > kLimit) CHECK(rail->at[static_cast<std::size_t>(row)]);
  }
  CHECK_FALSE(rail_of(with_noise(pulls(1.0), kNoise)).has_value());
}

TEST(Rail, a_pile_is_as_wide_as_the_noise_that_the_sensor_has_at_rest) {
  constexpr double kWide = 0.7;  // A: what lies within three of it is 7 % of the limit
  const auto rail = rail_of(with_noise(clipped(pulls(1.0)), kWide));
  CHECK(rail.has_value());
  DOUBLES_EQUAL(kLimit, rail->limit_a, kWide);
  CHECK_FALSE(rail_of(with_noise(pulls(1.0), kWide)).has_value());
}

TEST(Rail, a_rest_that_reads_a_step_below_zero_is_no_rail_beside_a_limit) {
  constexpr double kStep = 0.9;
  VectorXd current = with_noise(clipped(pulls(1.0)), kNoise);
  for (Index row = 0; row < kRows; ++row) {
    const bool low = row % 3 == 0 && std::abs(current(row)) < 1.0;  // between two steps
    current(row) = low ? -kStep : kStep * std::round(current(row) / kStep);
  }
  CHECK((current.array() == -kStep).count() > 100);
  const auto rail = rail_of(current);
  CHECK(rail.has_value());
  DOUBLES_EQUAL(kLimit, rail->limit_a, 0.5 * kStep);
  DOUBLES_EQUAL(kStep, rail->step_a, 1e-9);
}

TEST(Rail, the_uppermost_of_coarse_steps_is_no_rail_of_its_own) {
  constexpr double kStep = 0.5, kMiddle = 60.2;
  const auto read = [kStep](const VectorXd& values) { return VectorXd((values / kStep).array().round() * kStep); };
  const VectorXd limited = pulls(1.0).cwiseMin(kMiddle);
  const auto rail = rail_of(read(with_noise(limited, 0.3)));
  CHECK(rail.has_value());
  DOUBLES_EQUAL(kMiddle, rail->limit_a, 0.5 * kStep);
  for (Index row = 0; row < kRows; ++row) {
    if (pulls(1.0)(row) > kMiddle) CHECK(rail->at[static_cast<std::size_t>(row)]);
  }
  CHECK_FALSE(rail_of(read(with_noise(pulls(1.0), 0.3))).has_value());
}

TEST(Rail, a_small_pile_above_many_large_readings_is_a_rail_when_it_is_three_times_as_dense) {
  const auto current = [](double times) {  // `times` as many in the pile's 0.7 A as in the 0.7 A below it
    constexpr Index kPile = 280;
    constexpr double kWidth = 0.7;
    const double each = times * kWidth / static_cast<double>(kPile);  // A from one reading to the next
    VectorXd out(kRows);
    for (Index row = 0; row < kRows; ++row) {
      out(row) = row < kPile ? kLimit : std::max(0.0, kLimit - each * static_cast<double>(row - kPile));
    }
    return with_noise(out, kNoise);
  };
  const auto rail = rail_of(current(5.5));
  CHECK(rail.has_value());
  DOUBLES_EQUAL(kLimit, rail->limit_a, 0.1);
  CHECK_FALSE(rail_of(current(1.5)).has_value());
}

TEST(Rail, rows_at_the_limit_are_listed_as_not_used) {
  const VectorXd read = with_noise(clipped(pulls(1.0)), kNoise);
  const auto found = rail_of(read);
  CHECK(found.has_value());
  Recording log;
  log.time_s = VectorXd::LinSpaced(kRows, 0.0, 0.1 * (kRows - 1));
  log.signals["current"] = read;
  std::vector<Masked> said;
  mask_rail(*found, log, said);
  CHECK(!said.empty());
  for (const Masked& stretch : said) {
    CHECK(stretch.channel == "current");
    const auto first = static_cast<std::size_t>(std::lround(10.0 * stretch.start_s));
    CHECK(found->at[first]);
  }
}
