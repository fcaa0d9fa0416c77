// SPDX-License-Identifier: Apache-2.0
// The sums that every fit is made of, beside the covariance of the noise written out.
#include "explain/fit/gram.hpp"

#include <CppUTest/TestHarness.h>

#include <cmath>
#include <random>

namespace voltlap::explain {
namespace {

/// Drawn columns, with a gap in time and another number of rows in each block.
ChannelColumns drawn(std::mt19937& random, Index rows, Index width, Index blocks) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  ChannelColumns out;
  out.time_s = VectorXd::LinSpaced(rows, 0.0, 0.1 * static_cast<double>(rows - 1));
  out.time_s.tail(rows / 3).array() += 20.0;
  out.rough = VectorXd::NullaryExpr(rows, [&] { return uniform(random); });
  out.values = RowsXd::NullaryExpr(rows, width, [&] { return normal(random); });
  for (Index c = 0; c + 1 < width; ++c) out.column.push_back(c);
  for (Index k = 0; k < rows; ++k) out.block.push_back(k * k * blocks / (rows * rows));
  return out;
}

MatrixXd covariance(const ChannelColumns& of, const NoisePoint& noise) {
  const Index n = of.time_s.size();
  MatrixXd out = MatrixXd::Zero(n, n);
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j < n && noise.slow_share > 0.0; ++j)
      out(i, j) = noise.slow_share * std::exp(-std::abs(of.time_s(i) - of.time_s(j)) / noise.slow_tau_s);
    out(i, i) += 1.0 + noise.rough_share * of.rough(i) * of.rough(i);
  }
  return out;
}

}  // namespace

TEST_GROUP(Gram){};

TEST(Gram, TheSumsAreThoseOfTheNoisesCovariance) {
  std::mt19937 random(1);
  for (const Index width : {1, 2, 3, 7}) {
    for (const Index rows : {5, 61, 90}) {
      const ChannelColumns columns = drawn(random, rows, width, 4);
      const ChannelGram gram(columns, noise_grid(true), 4);
      for (std::size_t g = 0; g < gram.noise.size(); ++g) {
        const Eigen::LLT<MatrixXd> of(covariance(columns, gram.noise[g]));
        const MatrixXd values = columns.values, expected = values.transpose() * of.solve(values);
        const double log_det = 2.0 * MatrixXd(of.matrixL()).diagonal().array().log().sum();
        DOUBLES_EQUAL(0.0, (gram.all[g].gram - expected).norm() / expected.norm(), 1e-8);
        DOUBLES_EQUAL(log_det, gram.all[g].log_det, 1e-8 * static_cast<double>(rows));
        DOUBLES_EQUAL(static_cast<double>(rows), gram.all[g].count, 0.0);
      }
    }
  }
}

TEST(Gram, TheBlocksAddUpToTheWhole) {
  std::mt19937 random(2);
  constexpr Index kParts = 6;
  const ChannelGram gram(drawn(random, 203, 5, kParts), noise_grid(true), kParts);
  for (std::size_t g = 0; g < gram.noise.size(); ++g) {
    MatrixXd sum = MatrixXd::Zero(5, 5);
    double log_det = 0.0, count = 0.0;
    for (Index b = 0; b < kParts; ++b) {
      sum += gram.of_block(g, b).gram;
      log_det += gram.of_block(g, b).log_det;
      count += gram.of_block(g, b).count;
    }
    DOUBLES_EQUAL(0.0, (gram.all[g].gram - sum).norm() / sum.norm(), 1e-9);
    DOUBLES_EQUAL(log_det, gram.all[g].log_det, 1e-8);
    DOUBLES_EQUAL(203.0, count, 0.0);
  }
}

}  // namespace voltlap::explain
