// SPDX-License-Identifier: Apache-2.0
#include "explain/fit/gram.hpp"

#include <algorithm>
#include <cmath>

namespace voltlap::explain {
namespace {

constexpr double kSameStep = 1e-3;  // of a step between bins: how much of a slow part it keeps is the same

/// Sum of the logarithms; of products of a few, which is quicker.
double log_sum(const VectorXd& values) {
  constexpr Index kTogether = 16;
  double out = 0.0;
  for (Index k = 0; k < values.size(); k += kTogether) {
    out += std::log(values.segment(k, std::min(kTogether, values.size() - k)).prod());
  }
  return out;
}

/// Errors of prediction of every column, each over its standard deviation. Returns the variances.
VectorXd filter(const ChannelColumns& channel, const NoisePoint& noise, RowsXd& out) {
  const Index n = channel.values.rows();
  VectorXd variances(n);
  double last_step = 0.0, keeps = 1.0;
  Eigen::RowVectorXd mean = Eigen::RowVectorXd::Zero(channel.values.cols());
  double variance = noise.slow_share;
  for (Index k = 0; k < n; ++k) {
    if (k > 0 && noise.slow_share > 0.0) {
      const double step = channel.time_s(k) - channel.time_s(k - 1);
      if (std::abs(step - last_step) > kSameStep * step)
        keeps = std::exp(-step / noise.slow_tau_s), last_step = step;
      mean *= keeps;
      variance = keeps * keeps * variance + (1.0 - keeps * keeps) * noise.slow_share;
    }
    const double white = 1.0 + noise.rough_share * channel.rough(k) * channel.rough(k);
    const double total = variance + white;
    variances(k) = total;
    out.row(k) = channel.values.row(k) - mean;
    if (noise.slow_share > 0.0) {
      mean += (variance / total) * out.row(k);
      variance *= white / total;
    }
    out.row(k) /= std::sqrt(total);
  }
  return variances;
}

Products products_of(const RowsXd& rows) {
  Products out;
  out.gram = MatrixXd::Zero(rows.cols(), rows.cols());
  out.gram.selfadjointView<Eigen::Lower>().rankUpdate(rows.transpose());
  out.gram.triangularView<Eigen::StrictlyUpper>() = out.gram.transpose();
  out.count = static_cast<double>(rows.rows());
  return out;
}

}  // namespace

std::vector<NoisePoint> noise_grid(bool with_rough) {
  std::vector<NoisePoint> out;
  for (const double rough : {0.0, 1.0, 10.0}) {
    if (rough > 0.0 && !with_rough) break;
    out.push_back({0.0, 0.0, rough});
    for (const double tau : {2.0, 10.0, 50.0, 250.0}) {
      for (const double share : {0.1, 1.0, 10.0, 100.0}) out.push_back({tau, share, rough});
    }
  }
  return out;
}

ChannelGram gram_of(const ChannelColumns& channel, const std::vector<NoisePoint>& grid, Index blocks) {
  ChannelGram out;
  out.column = channel.column;
  const Index n = channel.values.rows(), width = channel.values.cols();
  RowsXd filtered(n, width);
  for (const NoisePoint& noise : grid) {
    const VectorXd variances = filter(channel, noise, filtered);
    Products all;
    all.gram = MatrixXd::Zero(width, width);
    std::vector<Products> by_block;
    Index first = 0;
    for (Index b = 0; b < blocks; ++b) {
      Index end = first;
      while (end < n && channel.block[static_cast<std::size_t>(end)] == b) ++end;
      Products part = products_of(filtered.middleRows(first, end - first));
      part.log_det = log_sum(variances.segment(first, end - first));
      all.gram += part.gram;
      all.log_det += part.log_det;
      all.count += part.count;
      by_block.push_back(std::move(part));
      first = end;
    }
    out.by_block.push_back(std::move(by_block));
    out.all.push_back(std::move(all));
  }
  return out;
}

}  // namespace voltlap::explain
