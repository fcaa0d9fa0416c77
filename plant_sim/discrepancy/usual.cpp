// SPDX-License-Identifier: Apache-2.0
#include "discrepancy/usual.hpp"

#include <algorithm>
#include <cmath>

namespace voltlap::plant {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kMeanVariance = 4.0;    // P, typical sizes squared
constexpr double kStartVariance = 0.1;   // v before the references are heard
constexpr double kPriorLogs = 2.0;       // weight of the common value of v, in logs
constexpr double kLeastVariance = 1e-6;
constexpr int kRounds = 15;

/// Sums of a reference in the order of another log's columns; a column that it lacks says nothing.
BlockSum in_order_of(const Design& design, const Reference& reference, const std::vector<double>& inflation) {
  const BlockSum own = reference.score.sum(inflation);
  const auto p = static_cast<Index>(design.columns.size());
  std::vector<Index> from(design.columns.size(), -1);
  for (std::size_t k = 0; k < design.columns.size(); ++k) {
    const auto& theirs = reference.design->columns;
    const auto found = std::find_if(theirs.begin(), theirs.end(),
                                    [&](const Column& c) { return c.key == design.columns[k].key; });
    if (found != theirs.end()) from[k] = static_cast<Index>(found - theirs.begin());
  }
  BlockSum out = empty_sum(p);
  out.rows = own.rows;
  out.energy = own.energy;
  for (Index a = 0; a < p; ++a) {
    const Index fa = from[static_cast<std::size_t>(a)];
    if (fa < 0) continue;
    out.score(a) = own.score(fa);
    for (Index b = 0; b < p; ++b) {
      const Index fb = from[static_cast<std::size_t>(b)];
      if (fb >= 0) out.gram(a, b) = own.gram(fa, fb);
    }
  }
  return out;
}

/// How much the block scores of the remainder scatter beyond white noise: 80 % quantile over the columns.
double inflation_of(const std::vector<BlockSum>& blocks) {
  BlockSum all = empty_sum(blocks.front().score.size());
  for (const BlockSum& block : blocks) all.add(block);
  MatrixXd regular = all.gram;
  regular.diagonal().array() += 1.0 / 9.0;
  const VectorXd fit = regular.ldlt().solve(all.score);
  std::vector<double> ratios;
  for (Index k = 0; k < fit.size(); ++k) {
    if (all.gram(k, k) <= 0.0) continue;
    double scatter = 0.0;
    for (const BlockSum& block : blocks) {
      const double s = block.score(k) - block.gram.row(k).dot(fit);
      scatter += s * s;
    }
    ratios.push_back(scatter / all.gram(k, k));
  }
  if (ratios.empty()) return 1.0;
  std::sort(ratios.begin(), ratios.end());
  return std::max(1.0, ratios[ratios.size() * 8 / 10]);
}

/// What no log tells beforehand. Without references every signature may be there to a fiftieth of its usual size: what
/// the rows do not resolve of the current, the plant's steps, thermistors that are not the cell.
VectorXd always_free(const Design& design, bool with_references) {
  constexpr double kModelError = 0.0004;
  VectorXd v = VectorXd::Constant(static_cast<Index>(design.columns.size()), with_references ? 0.0 : kModelError);
  for (std::size_t k = 0; k < design.columns.size(); ++k) {
    const std::string& key = design.columns[k].key;
    if (key.starts_with("local/")) v(static_cast<Index>(k)) = 0.0;
    if (key.starts_with("initial_soc/")) v(static_cast<Index>(k)) = design.comparison.facts.starts_at_rest ? 0.04 : 2.0;
  }
  return v;
}

void learn(const Design& design, const std::vector<Reference>& references, Usual& out) {
  std::vector<BlockSum> sums;
  for (const Reference& reference : references) sums.push_back(in_order_of(design, reference, out.inflation));
  const auto p = static_cast<Index>(design.columns.size());
  const auto n = static_cast<double>(sums.size());
  const MatrixXd one = MatrixXd::Identity(p, p);
  VectorXd v = VectorXd::Constant(p, kStartVariance);
  MatrixXd mean_covariance = MatrixXd::Zero(p, p);
  for (int round = 0; round < kRounds; ++round) {
    std::vector<MatrixXd> discount;
    MatrixXd information = one / kMeanVariance;
    VectorXd score = VectorXd::Zero(p);
    for (const BlockSum& sum : sums) {
      discount.push_back((one + sum.gram * v.asDiagonal()).partialPivLu().inverse());
      information += discount.back() * sum.gram;
      score += discount.back() * sum.score;
    }
    mean_covariance = information.ldlt().solve(one);
    out.mean = mean_covariance * score;
    VectorXd second = VectorXd::Zero(p);
    for (std::size_t k = 0; k < sums.size(); ++k) {
      const VectorXd u = v.cwiseProduct(discount[k] * (sums[k].score - sums[k].gram * out.mean));
      const MatrixXd a = discount[k] * sums[k].gram;
      second += u.cwiseAbs2() + (v - v.cwiseProduct(a.diagonal()).cwiseProduct(v)).cwiseMax(0.0);
    }
    const double common = std::exp((second / n).cwiseMax(kLeastVariance).array().log().mean());
    v = ((second.array() + kPriorLogs * common) / (n + kPriorLogs)).cwiseMax(kLeastVariance).matrix();
  }
  out.variance = mean_covariance;
  out.variance.diagonal() += v * (1.0 + 1.5 / n);
  // What this log alone has columns for is no part of what is usual.
  for (Index k = 0; k < p; ++k) {
    if (!design.columns[static_cast<std::size_t>(k)].key.starts_with("local/")) continue;
    out.mean(k) = 0.0;
    out.variance.row(k).setZero();
    out.variance.col(k).setZero();
  }
}

/// Median and its robust spread.
std::pair<double, double> robust(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  const double median = *middle;
  for (double& v : values) v = std::abs(v - median);
  std::nth_element(values.begin(), middle, values.end());
  return {median, 1.4826 * *middle};
}

MatrixXd coefficients(const GroupScore& score) {
  MatrixXd gram = score.gram;
  gram.diagonal().array() += 1.0 / 9.0;
  return gram.ldlt().solve(score.score);
}

void learn_groups(const Design& design, const Score& score, const std::vector<Reference>& references, Usual& out) {
  for (std::size_t g = 0; g < score.groups.size(); ++g) {
    const MatrixXd own = coefficients(score.groups[g]);
    MatrixXd mean = MatrixXd::Zero(own.rows(), own.cols());
    std::vector<MatrixXd> theirs;
    for (const Reference& reference : references) {
      const auto& groups = reference.design->comparison.groups;
      for (std::size_t r = 0; r < groups.size(); ++r) {
        const bool same = groups[r].members == design.comparison.groups[g].members &&
                          reference.score.groups[r].gram.rows() == own.rows();
        if (same) theirs.push_back(coefficients(reference.score.groups[r]));
      }
    }
    for (const MatrixXd& t : theirs) mean += t / static_cast<double>(theirs.size());
    const bool thermal = design.comparison.groups[g].balance == Balance::kHeat;
    const double least = theirs.empty() && thermal ? 0.2 : 0.02;
    VectorXd v(own.rows());
    for (Index k = 0; k < own.rows(); ++k) {
      std::vector<double> sample;
      for (Index i = 0; i < own.cols(); ++i) {
        if (theirs.empty()) sample.push_back(own(k, i));
        for (const MatrixXd& t : theirs) sample.push_back((t(k, i) - mean(k, i)) * std::sqrt(1.0 + 2.0 / static_cast<double>(theirs.size())));
      }
      const double spread = robust(std::move(sample)).second;
      v(k) = std::max(spread * spread, least * least);
    }
    out.group_mean.push_back(theirs.empty() ? MatrixXd::Zero(own.rows(), own.cols()) : mean);
    out.group_variance.push_back(v);
  }
}

}  // namespace

Usual usual_discrepancy(const Design& design, const Score& score, const std::vector<Reference>& references) {
  Usual out;
  const auto p = static_cast<Index>(design.columns.size());
  out.references = references.size();
  out.mean = VectorXd::Zero(p);
  out.variance = MatrixXd::Zero(p, p);
  for (std::size_t c = 0; c < score.channels.size(); ++c) {
    double inflation = references.empty() ? inflation_of(score.channels[c]) : 1.0;
    for (const Reference& reference : references) {
      inflation = std::max(inflation, inflation_of(reference.score.channels[c]));
    }
    out.inflation.push_back(inflation);
  }
  if (!references.empty()) learn(design, references, out);
  out.variance.diagonal() += always_free(design, !references.empty());
  learn_groups(design, score, references, out);
  return out;
}

Usual group_spread(const Design& design, const Score& score, const std::vector<Reference>& references) {
  Usual out;
  learn_groups(design, score, references, out);
  return out;
}

Remaining remaining(const BlockSum& sum, const Usual& usual) {
  const Index p = sum.score.size();
  const auto lu = (MatrixXd::Identity(p, p) + sum.gram * usual.variance).partialPivLu();
  Remaining out{lu.solve(sum.gram), lu.solve(sum.score - sum.gram * usual.mean)};
  out.information = 0.5 * (out.information + out.information.transpose()).eval();
  return out;
}

}  // namespace voltlap::plant
