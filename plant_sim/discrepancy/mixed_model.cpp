// SPDX-License-Identifier: Apache-2.0
#include "discrepancy/mixed_model.hpp"

#include <algorithm>

#include "discrepancy/discount.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Mean of `values` over the columns of a kind, drawn to the square of what is expected; by column.
VectorXd shared(const VectorXd& values, const ColumnPrior& prior, const VectorXd& expected, double logs) {
  const std::vector<std::size_t>& kin = prior.kin;
  const std::size_t kinds = kin.empty() ? 0 : *std::max_element(kin.begin(), kin.end()) + 1;
  VectorXd sum = VectorXd::Zero(static_cast<Index>(kinds)), weight = sum, square = sum;
  for (Index k = 0; k < values.size(); ++k) {
    const auto g = static_cast<Index>(kin[static_cast<std::size_t>(k)]);
    sum(g) += values(k);
    weight(g) += logs;
    square(g) = expected(k) * expected(k);
  }
  VectorXd out(values.size());
  for (Index k = 0; k < values.size(); ++k) {
    const auto g = static_cast<Index>(kin[static_cast<std::size_t>(k)]);
    out(k) = (sum(g) + prior.columns * logs * square(g)) / (weight(g) + prior.columns * logs);
  }
  return out;
}

}  // namespace

MatrixXd MixedModel::variance() const {
  MatrixXd out = mean_covariance;
  out.diagonal() += between;
  return out;
}

MixedModel mixed_model(const std::vector<LogSums>& logs, const ColumnPrior& prior, int rounds) {
  const Index q = prior.usual.size();
  const auto count = static_cast<double>(logs.size());
  const MatrixXd one = MatrixXd::Identity(q, q);
  VectorXd common = prior.usual.cwiseAbs2();
  MixedModel out;
  out.between = (prior.start * prior.repeats).cwiseAbs2();
  for (int round = 0;; ++round) {
    MatrixXd information = common.cwiseInverse().asDiagonal();
    VectorXd score = VectorXd::Zero(q);
    std::vector<Discount> discount;
    std::vector<MatrixXd> told;
    for (const LogSums& log : logs) {
      discount.push_back(Discount::by_variances(log.gram, out.between));
      told.push_back(discount.back().information());
      information += told.back();
      score += discount.back().score(log.score);
    }
    out.mean_covariance = information.ldlt().solve(one);
    out.mean = out.mean_covariance * score;
    VectorXd second = VectorXd::Zero(q);
    out.own.clear();
    for (std::size_t k = 0; k < logs.size(); ++k) {
      const VectorXd u = discount[k].amounts(logs[k].score - logs[k].gram * out.mean);
      out.own.push_back(out.mean + u);
      const MatrixXd& known = told[k];
      const MatrixXd follows = out.between.asDiagonal() * known;  // -du/dm
      second += u.cwiseAbs2() +
                (out.between - out.between.cwiseProduct(known.diagonal()).cwiseProduct(out.between)).cwiseMax(0.0) +
                (follows * out.mean_covariance).cwiseProduct(follows).rowwise().sum();
    }
    if (round == rounds) return out;
    common = shared(out.mean.cwiseAbs2() + out.mean_covariance.diagonal(), prior, prior.usual, 1.0);
    out.between = shared(second, prior, prior.repeats, count);
  }
}

}  // namespace voltlap::plant
