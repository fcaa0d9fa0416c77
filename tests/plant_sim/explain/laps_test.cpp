// SPDX-License-Identifier: Apache-2.0
// A course asks for the same speed in every lap: its length and the stints are found from the speed alone.
#include "explain/balances/laps.hpp"

#include <cmath>
#include <random>

#include <CppUTest/TestHarness.h>

using voltlap::plant::lap_length;
using voltlap::plant::Recording;
using voltlap::plant::stints_of;

namespace {

constexpr double kLap = 700.0, kTurn = 2.0 * 3.14159265358979323846;

/// Two stints of a few minutes with a stop between them.
template <class SpeedAt>
Recording drive(const SpeedAt& speed_at) {
  constexpr Eigen::Index kRows = 5000, kStop = 2000, kGo = 3000;
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0.0, 0.03);
  Recording log;
  log.time_s = Eigen::VectorXd::LinSpaced(kRows, 0.0, 0.1 * (kRows - 1));
  Eigen::VectorXd speed = Eigen::VectorXd::Zero(kRows);
  double position = 0.0;
  for (Eigen::Index row = 0; row < kRows; ++row) {
    if (row >= kStop && row < kGo) continue;
    speed(row) = speed_at(position) + noise(random);
    position += 0.1 * speed(row);
  }
  log.signals["speed"] = speed;
  return log;
}

double of_a_lap(double position) {
  return 12.0 + 4.0 * std::sin(kTurn * position / kLap) + 2.0 * std::sin(3.0 * kTurn * position / kLap + 1.0);
}

}  // namespace

TEST_GROUP(Laps){};

TEST(Laps, the_lap_is_what_the_speed_repeats_after) {
  const Recording log = drive(of_a_lap);
  DOUBLES_EQUAL(kLap, lap_length(log, stints_of(log, 2)), 8.0);
}

TEST(Laps, a_drive_that_never_repeats_has_no_lap) {
  const Recording log = drive([](double position) { return 12.0 + 4.0 * std::sin(std::pow(position / 150.0, 2)); });
  DOUBLES_EQUAL(0.0, lap_length(log, stints_of(log, 2)), 0.0);
}

TEST(Laps, a_stop_ends_a_stint) {
  const Recording log = drive(of_a_lap);
  const auto stints = stints_of(log, 2);
  LONGS_EQUAL(2, stints.size());
  LONGS_EQUAL(0, stints[0].first);
  LONGS_EQUAL(2000, stints[0].position_m.size());
  LONGS_EQUAL(3000, stints[1].first);
}

TEST(Laps, the_longest_stints_are_kept) {
  const Recording log = drive(of_a_lap);
  const auto stints = stints_of(log, 1);
  LONGS_EQUAL(1, stints.size());
}
