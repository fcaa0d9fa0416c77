// SPDX-License-Identifier: Apache-2.0
// Logs drawn from known a and b: what they have in common and what differs between them is found again.
#include "discrepancy/mixed_model.hpp"

#include <cmath>
#include <random>

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr Index kColumns = 40;
constexpr Index kRows = 400;

/// Logs y = X (m + u) + noise of one, X of independent columns.
std::vector<LogSums> logs_of(std::size_t count, double common, double between, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const auto drawn = [&](Index rows, Index columns) {
    MatrixXd out(rows, columns);
    for (Index k = 0; k < out.size(); ++k) out(k) = normal(random);
    return out;
  };
  const VectorXd m = common * drawn(kColumns, 1);
  std::vector<LogSums> out;
  for (std::size_t k = 0; k < count; ++k) {
    const MatrixXd x = drawn(kRows, kColumns);
    const VectorXd y = x * (m + between * drawn(kColumns, 1)) + drawn(kRows, 1);
    out.push_back({x.transpose() * x, x.transpose() * y});
  }
  return out;
}

ColumnPrior prior_of(double usual, double repeats) {
  ColumnPrior out;
  out.kin.assign(kColumns, 0);
  out.usual = VectorXd::Constant(kColumns, usual);
  out.repeats = VectorXd::Constant(kColumns, repeats);
  return out;
}

}  // namespace

TEST_GROUP(MixedModel){};

TEST(MixedModel, WhatDiffersBetweenLogsIsFoundThoughLessWasExpected) {
  const MixedModel model = mixed_model(logs_of(4, 2.0, 0.5, 1), prior_of(1.0, 0.2), 60);
  const double between = std::sqrt(model.between(0));
  CHECK(between > 0.4 && between < 0.6);
}

TEST(MixedModel, LogsThatAgreeHaveLittleBetweenThem) {
  const MixedModel model = mixed_model(logs_of(4, 2.0, 0.0, 2), prior_of(1.0, 0.2), 60);
  CHECK(std::sqrt(model.between(0)) < 0.1);
}

TEST(MixedModel, NewLogLiesWithinTheVarianceThatIsSaid) {
  int inside = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    const std::vector<LogSums> logs = logs_of(4, 2.0, 0.5, 100 + seed);
    const MixedModel model = mixed_model({logs.begin(), logs.end() - 1}, prior_of(1.0, 0.3), 40);
    const VectorXd seen = logs.back().gram.ldlt().solve(logs.back().score);
    const MatrixXd variance = model.variance() + MatrixXd(logs.back().gram.inverse());
    for (Index k = 0; k < kColumns; ++k) inside += std::abs(seen(k) - model.mean(k)) < 1.96 * std::sqrt(variance(k, k));
  }
  const double share = inside / (20.0 * kColumns);  // standard error 0.8 %
  CHECK(share > 0.925 && share < 0.975);
}
