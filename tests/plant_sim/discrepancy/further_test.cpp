// SPDX-License-Identifier: Apache-2.0
// Beside a strong cause another is named when it moves otherwise, and not when it could be what the first one's
// signature misses.
#include "discrepancy/further.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double kStrong = 100.0, kWeak = 8.0;  // standard errors
constexpr double kError = 0.01;

/// Two channels of two blocks each, with columns of unit information: the strong cause, and others beside it.
struct Log {
  System system;
  Score score;
  std::vector<double> inflation{1.0, 1.0};

  explicit Log(int columns) {
    system.information = 100.0 * MatrixXd::Identity(columns, columns);
    system.score = VectorXd::Zero(columns);
    system.prior_variance = VectorXd::Constant(columns, 9.0);
    for (int k = 0; k < columns; ++k) {
      Candidate candidate;
      candidate.cause = k;
      candidate.rows = {k};
      system.candidates.push_back(candidate);
    }
    score.channels.assign(2, {empty_sum(columns), empty_sum(columns)});
  }

  void shows(int column, double standard_errors) { system.score(column) = 10.0 * standard_errors; }

  /// The raw signature of a column: 50 in each block of its channel.
  void lives_in(int column, std::size_t channel) {
    for (BlockSum& block : score.channels[channel]) block.gram(column, column) = 50.0;
  }

  /// As much of another column in the first block as there is against it in the second.
  void follows(int column, int other, double share) {
    for (const std::size_t block : {0, 1}) {
      MatrixXd& gram = score.channels[0][block].gram;
      gram(column, other) = gram(other, column) = (block == 0 ? 50.0 : -50.0) * share;
    }
  }

  [[nodiscard]] Beside beside() const { return {system, score, inflation, 0.0, kError}; }
};

/// A strong cause, and two weaker ones in another channel that share so much of their information of 100.
Log two_beside(double shared) {
  Log log(3);
  log.shows(0, kStrong);
  log.lives_in(0, 0);
  for (const int column : {1, 2}) {
    log.shows(column, kWeak);
    log.lives_in(column, 1);
  }
  log.system.information(1, 2) = log.system.information(2, 1) = shared;
  return log;
}

Decision strong_alone() {
  Decision out;
  out.members = {0};
  out.equivalents = {{}};
  out.margin = 30.0;
  return out;
}

}  // namespace

TEST_GROUP(Further) {};

TEST(Further, ACauseInAnotherChannelIsNamedBesideAStrongOne) {
  Log log(2);
  log.shows(0, kStrong);
  log.shows(1, kWeak);
  log.lives_in(0, 0);
  log.lives_in(1, 1);
  const auto both = with_further_causes(log.beside(), strong_alone());
  CHECK(both.has_value());
  CHECK(both->members == (std::vector<std::size_t>{0, 1}));
  CHECK(both->margin < 30.0);
}

TEST(Further, WhatFollowsTheStrongCauseByBlocksMayBeWhatItsSignatureMisses) {
  Log log(2);
  log.shows(0, kStrong);
  log.shows(1, kWeak);
  log.lives_in(0, 0);
  log.lives_in(1, 0);
  CHECK(with_further_causes(log.beside(), strong_alone()).has_value());
  log.follows(1, 0, 0.7);
  DOUBLES_EQUAL(0.49, likeness_by_block(log.beside(), VectorXd::Unit(2, 0), VectorXd::Unit(2, 1)), 1e-12);
  CHECK_FALSE(with_further_causes(log.beside(), strong_alone()).has_value());
}

TEST(Further, TwoThatExplainTheRestEquallyWellLeaveADoubt) {
  const Log log = two_beside(90.0);  // alike, but not the same
  CHECK_FALSE(with_further_causes(log.beside(), strong_alone()).has_value());
}

TEST(Further, OfOneClassBothAreSaid) {
  const Log log = two_beside(99.9);
  const auto both = with_further_causes(log.beside(), strong_alone());
  CHECK(both.has_value());
  LONGS_EQUAL(2, both->members.size());
  LONGS_EQUAL(1, both->equivalents[1].size());
}

TEST(Further, OneClassIsWhatTheRestCannotTellApart) {
  Log log(3);
  for (const int column : {1, 2}) log.lives_in(column, 1);
  log.lives_in(0, 0);
  // 0.4 of the strong cause and the same of something else: one with it, one against it.
  log.system.information << 100.0, 40.0, -40.0, 40.0, 116.0, 83.9, -40.0, 83.9, 116.0;
  log.system.score = log.system.information * VectorXd({{1.0, 0.8, 0.0}});
  const auto both = with_further_causes(log.beside(), strong_alone());
  CHECK(both.has_value());
  LONGS_EQUAL(1, both->equivalents[1].size());
}

TEST(Further, ASmallRestIsNotNamed) {
  Log log(2);
  log.shows(0, kStrong);
  log.shows(1, 0.5 * kWeak);
  log.lives_in(0, 0);
  log.lives_in(1, 1);
  CHECK_FALSE(with_further_causes(log.beside(), strong_alone()).has_value());
}

TEST(Further, AShapeWithoutANameIsNotAdded) {
  Log log(2);
  log.shows(0, kStrong);
  log.shows(1, 2.0 * kWeak);
  log.lives_in(0, 0);
  log.lives_in(1, 1);
  log.system.candidates[1].cause = -1;
  CHECK_FALSE(with_further_causes(log.beside(), strong_alone()).has_value());
}

TEST(Further, ACurveThatBendsToWhateverIsLeftIsNotAdded) {
  Log log(4);
  log.shows(0, kStrong);
  for (const int column : {1, 2, 3}) {
    log.shows(column, kWeak);
    log.lives_in(column, 1);
  }
  log.lives_in(0, 0);
  log.system.candidates[1].rows = {1, 2, 3};
  log.system.candidates.resize(2);
  CHECK_FALSE(with_further_causes(log.beside(), strong_alone()).has_value());
  log.system.candidates[1].rows = {1, 2};
  CHECK(with_further_causes(log.beside(), strong_alone()).has_value());
}
