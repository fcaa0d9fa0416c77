// SPDX-License-Identifier: Apache-2.0
#include "explain/fit/gram.hpp"

#include <cmath>
#include <utility>

namespace voltlap::explain {
namespace {

constexpr double kSameStep = 1e-3;  // of a step between bins: how much of a slow part it keeps is the same

/// Each loop below is one that a compiler makes wide by itself; wider yet where the machine can. No sum is put in
/// another order for it: results are the same on all.
#if defined(__x86_64__) && defined(__linux__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define VOLTLAP_WIDE __attribute__((target_clones("avx2", "default")))
#else
#define VOLTLAP_WIDE
#endif

struct Filter {
  double keeps = 1.0, gain = 0.0, scale = 1.0;  ///< of the slow part from row to row; of an error; to its deviation
};
/// One row through the filter: `mean` is what is expected of the slow part.
VOLTLAP_WIDE void filter_row(const double* values, double* mean, double* out, Index width, Filter filter) {
  for (Index c = 0; c < width; ++c) {
    const double expected = filter.keeps * mean[c], error = values[c] - expected;
    mean[c] = expected + filter.gain * error;
    out[c] = filter.scale * error;
  }
}

/// Adds the products of four rows that lie one after the other: gram(i, j) for j <= i.
VOLTLAP_WIDE void add_four(const double* rows, Index width, double* gram) {
  const double *a = rows, *b = a + width, *c = b + width, *d = c + width;
  for (Index i = 0; i < width; ++i) {
    double* out = gram + i * width;
    const double x = a[i], y = b[i], z = c[i], w = d[i];
    for (Index j = 0; j <= i; ++j) out[j] += (x * a[j] + y * b[j]) + (z * c[j] + w * d[j]);
  }
}
VOLTLAP_WIDE void add_one(const double* row, Index width, double* gram) {
  for (Index i = 0; i < width; ++i) {
    double* out = gram + i * width;
    for (Index j = 0; j <= i; ++j) out[j] += row[i] * row[j];
  }
}

/// Products of a channel's errors of prediction, each over its standard deviation. Rows come one after the other;
/// block() closes what was added since the last one.
class Adding {
 public:
  explicit Adding(Index width) : width_(width), gram_(RowsXd::Zero(width, width)), waiting_(kTogether, width) {}

  [[nodiscard]] double* next() { return waiting_.row(waits_).data(); }
  void add(double variance) {
    log_det_ *= variance;
    ++count_;
    if (++waits_ == kTogether) flush();
  }
  [[nodiscard]] Products block() {
    flush();
    Products out{MatrixXd(width_, width_), log_sum_, count_};
    out.gram.triangularView<Eigen::Lower>() = gram_;
    out.gram.triangularView<Eigen::StrictlyUpper>() = out.gram.transpose();
    gram_.setZero();
    log_sum_ = count_ = 0.0;
    return out;
  }

 private:
  static constexpr Index kTogether = 4;
  void flush() {
    if (waits_ == kTogether) {
      add_four(waiting_.data(), width_, gram_.data());
    } else {
      for (Index k = 0; k < waits_; ++k) add_one(waiting_.row(k).data(), width_, gram_.data());
    }
    log_sum_ += std::log(log_det_);  // of a few at once, which is quicker
    log_det_ = 1.0;
    waits_ = 0;
  }

  Index width_;
  RowsXd gram_, waiting_;
  Index waits_ = 0;
  double log_det_ = 1.0, log_sum_ = 0.0, count_ = 0.0;
};

/// The scalars of the filter from row to row. Where rows are even they soon stay as they are.
class Gains {
 public:
  Gains(const ChannelColumns& channel, const NoisePoint& noise)
      : channel_(channel), noise_(noise), variance_(noise.slow_share) {}

  Filter filter;
  double total = 1.0;
  void go_to(Index k) {
    const double step = k > 0 ? channel_.time_s(k) - channel_.time_s(k - 1) : 0.0;
    const bool even = std::abs(step - last_step_) <= kSameStep * step;
    if (noise_.slow_share > 0.0 && !even) filter.keeps = std::exp(-step / noise_.slow_tau_s);
    last_step_ = step;
    if (noise_.rough_share == 0.0 && even && stays_) return;
    const double left = filter.keeps * filter.keeps;
    const double expected = left * variance_ + (1.0 - left) * noise_.slow_share;
    const double white = 1.0 + noise_.rough_share * channel_.rough(k) * channel_.rough(k);
    total = expected + white;
    filter.gain = expected / total;
    filter.scale = 1.0 / std::sqrt(total);
    const double after = filter.gain * white;
    stays_ = std::abs(after - variance_) <= kStays * after;
    variance_ = after;
  }

 private:
  static constexpr double kStays = 1e-12;
  const ChannelColumns& channel_;
  const NoisePoint& noise_;
  double variance_, last_step_ = 0.0;
  bool stays_ = false;
};

/// Products by block; one block takes all.
std::vector<Products> products_of(const ChannelColumns& channel, const NoisePoint& noise, Index blocks) {
  const Index n = channel.values.rows(), width = channel.values.cols();
  std::vector<Products> out;
  Adding adding(width);
  Gains gains(channel, noise);
  VectorXd mean = VectorXd::Zero(width);
  for (Index k = 0; k < n; ++k) {
    const Index block = blocks == 1 ? 0 : channel.block[static_cast<std::size_t>(k)];
    while (std::ssize(out) < block) out.push_back(adding.block());
    gains.go_to(k);
    filter_row(channel.values.data() + k * width, mean.data(), adding.next(), width, gains.filter);
    adding.add(gains.total);
  }
  while (std::ssize(out) < blocks) out.push_back(adding.block());
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

ChannelGram::ChannelGram(ChannelColumns columns, std::vector<NoisePoint> grid, Index blocks)
    : column(columns.column), noise(std::move(grid)), columns_(std::move(columns)), blocks_(blocks) {
  for (const NoisePoint& point : noise) all.push_back(products_of(columns_, point, 1).front());
  by_block_.resize(noise.size());
}

const Products& ChannelGram::of_block(std::size_t number, Index block) const {
  std::vector<Products>& known = by_block_[number];
  if (known.empty()) known = products_of(columns_, noise[number], blocks_);
  return known[static_cast<std::size_t>(block)];
}

}  // namespace voltlap::explain
