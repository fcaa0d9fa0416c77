// SPDX-License-Identifier: Apache-2.0
#include "explain/fit/hypothesis.hpp"

#include <algorithm>
#include <cmath>

namespace voltlap::explain {
namespace {

constexpr double kDecisive = 2.9957;  // ln 20
constexpr double kAgainst = 0.5;      // of what the blocks win that speak for it
constexpr double kFarthest = 3.0;     // of a nuisance's prior
constexpr int kRounds = 4;            // sizes follow the noise, the noise the sizes
constexpr double kTwoPi = 6.283185307179586;

/// The columns of a hypothesis as a channel has them: places in its Gram matrix and in the hypothesis.
struct Picked {
  std::vector<Index> gram, set;
};

Picked picked(const ChannelGram& channel, const std::vector<Index>& columns) {
  Picked out;
  for (std::size_t s = 0; s < columns.size(); ++s) {
    const auto found = std::lower_bound(channel.column.begin(), channel.column.end(), columns[s]);
    if (found == channel.column.end() || *found != columns[s]) continue;
    out.gram.push_back(found - channel.column.begin());
    out.set.push_back(static_cast<Index>(s));
  }
  return out;
}

/// X'X, X'y and y'y of the hypothesis' columns.
struct Normal {
  MatrixXd a;
  VectorXd c;
  double square = 0.0;
  [[nodiscard]] double left(const VectorXd& size) const {
    return std::max(1e-300, square - 2.0 * c.dot(size) + size.dot(a * size));
  }
};

Normal normal_of(const Products& products, const Picked& pick) {
  const auto n = static_cast<Index>(pick.gram.size());
  const Index last = products.gram.rows() - 1;
  Normal out{MatrixXd(n, n), VectorXd(n), products.gram(last, last)};
  for (Index i = 0; i < n; ++i) {
    const Index gi = pick.gram[static_cast<std::size_t>(i)];
    out.c(i) = products.gram(last, gi);
    for (Index j = 0; j < n; ++j) out.a(i, j) = products.gram(gi, pick.gram[static_cast<std::size_t>(j)]);
  }
  return out;
}

/// Where a nuisance would have to be further away than it can, it stays there: its effect leaves the residual, and
/// nothing is left to estimate.
struct Stay {
  Index column = 0;  ///< of the hypothesis
  double at = 0.0;
};
void stay(const std::vector<Stay>& stays, const Picked& pick, Normal& normal) {
  for (const Stay& one : stays) {
    const auto found = std::find(pick.set.begin(), pick.set.end(), one.column);
    if (found == pick.set.end()) continue;
    const Index k = found - pick.set.begin();
    normal.square += one.at * (one.at * normal.a(k, k) - 2.0 * normal.c(k));
    normal.c -= one.at * normal.a.col(k);
    normal.c(k) = 0.0;
    normal.a.row(k).setZero();
    normal.a.col(k).setZero();
  }
}

/// One fit's sums: all of a channel's noises for the whole log, and the blocks at the chosen one.
class Fitting {
 public:
  Fitting(const Problem& problem, const std::vector<Index>& columns) : problem_(problem), columns_(columns) {
    const auto n = static_cast<Index>(columns.size());
    prior_ = MatrixXd::Zero(n, n);
    for (Index k = 0; k < n; ++k) {
      const double sigma = problem.prior_sigma(columns[static_cast<std::size_t>(k)]);
      prior_(k, k) = 1.0 / (sigma * sigma);
    }
    for (const Curve& curve : problem.curves) put_bend(curve);
    for (const ChannelGram& channel : problem.channels) {
      picks_.push_back(picked(channel, columns));
      std::vector<Normal> by_noise;
      for (const Products& all : channel.all) by_noise.push_back(normal_of(all, picks_.back()));
      normals_.push_back(std::move(by_noise));
    }
    noise_.assign(problem.channels.size(), 0);
    variance_ = VectorXd::Ones(static_cast<Index>(problem.channels.size()));
  }

  void settle() {
    // Sizes follow the noise and the noise the sizes, from two sides: slow noise that takes an error at first may
    // keep it, with sizes that leave it there.
    size_ = VectorXd::Zero(static_cast<Index>(columns_.size()));
    go_on();
    const double cost = cost_;
    const VectorXd size = size_, variance = variance_;
    const std::vector<std::size_t> noise = noise_;
    std::fill(noise_.begin(), noise_.end(), 0);
    solve();  // as if all noise were white
    go_on();
    if (cost_ > cost) {
      size_ = size, variance_ = variance, noise_ = noise;
      solve();
    }
    const std::size_t most = problem_.nuisances.size();
    while (stays_.size() < most && keep_farthest()) go_on();
    for (const Stay& one : stays_) size_(one.column) = one.at;
  }

  /// The starts that plain least squares give beside sizes of causes: noise that swallows what is slow leaves a
  /// start open, and then it would be no measure of what an error is worth.
  void put_plain_starts(VectorXd& size) const {
    const auto n = static_cast<Index>(problem_.nuisances.size());
    if (n == 0) return;
    MatrixXd a = prior_;
    VectorXd right = VectorXd::Zero(prior_.rows());
    for (std::size_t c = 0; c < normals_.size(); ++c) {
      const Normal plain = normal_of(problem_.channels[c].all[0], picks_[c]);
      put(c, plain, problem_.least_sigma[c] * problem_.least_sigma[c], a, right);
    }
    const Index causes = size.size() - n;
    size.head(n) =
        bounded_starts(a.topLeftCorner(n, n), right.head(n) - a.topRightCorner(n, causes) * size.tail(causes),
                       prior_.diagonal().head(n).cwiseInverse().cwiseSqrt());
  }

  [[nodiscard]] Fit result() const {
    VectorXd plain = size_;
    put_plain_starts(plain);
    Fit out{columns_,
            size_,
            plain.head(static_cast<Index>(problem_.nuisances.size())),
            covariance_,
            VectorXd::Zero(problem_.blocks),
            MatrixXd::Zero(static_cast<Index>(problem_.channels.size()), problem_.blocks),
            noise_,
            variance_};
    for (Index b = 0; b < problem_.blocks; ++b) judge(b, out);
    return out;
  }

 private:
  void go_on() {
    for (int round = 0; round < kRounds; ++round) {
      choose_noise();
      solve();
    }
  }

  /// Precision of a curve's second differences, where the hypothesis has the curve.
  void put_bend(const Curve& curve) {
    const auto found = std::find(columns_.begin(), columns_.end(), curve.first);
    if (found == columns_.end()) return;
    const Index at = found - columns_.begin();
    const Eigen::Vector3d difference(1.0, -2.0, 1.0);
    for (Index k = at; k + 2 < at + curve.points; ++k)
      prior_.block<3, 3>(k, k) += difference * difference.transpose() / (curve.bend * curve.bend);
  }

  /// Holds the nuisance that is furthest beyond where it can be; false: none is.
  bool keep_farthest() {
    Stay next;
    double most = kFarthest * (1.0 + 1e-9);
    for (Index k = 0; k < static_cast<Index>(problem_.nuisances.size()); ++k) {
      const double by = std::abs(size_(k)) * std::sqrt(prior_(k, k));
      if (by > most) most = by, next = {k, std::copysign(kFarthest / std::sqrt(prior_(k, k)), size_(k))};
    }
    if (next.at == 0.0) return false;
    stays_.push_back(next);
    for (std::size_t c = 0; c < normals_.size(); ++c) {
      for (Normal& normal : normals_[c]) stay({next}, picks_[c], normal);
    }
    return true;
  }

  [[nodiscard]] VectorXd sizes_in(std::size_t c) const {
    VectorXd out(static_cast<Index>(picks_[c].set.size()));
    for (Index i = 0; i < out.size(); ++i) out(i) = size_(picks_[c].set[static_cast<std::size_t>(i)]);
    return out;
  }

  /// No sensor is better than the best, and what is slow beyond what sound logs have is an error, not noise.
  [[nodiscard]] double bounded(std::size_t c, std::size_t noise, double variance) const {
    const double least = problem_.least_sigma[c], most = problem_.most_slow[c];
    const double share = problem_.channels[c].noise[noise].slow_share;
    if (share * variance > most * most) variance = most * most / share;
    return std::max(variance, least * least);
  }

  void choose_noise() {
    cost_ = size_.dot(prior_ * size_);
    for (std::size_t c = 0; c < problem_.channels.size(); ++c) {
      const VectorXd size = sizes_in(c);
      double best = 1e300;
      for (std::size_t g = 0; g < normals_[c].size(); ++g) {
        const Products& all = problem_.channels[c].all[g];
        const double variance = bounded(c, g, normals_[c][g].left(size) / std::max(1.0, all.count));
        const double cost = all.count * std::log(variance) + all.log_det + normals_[c][g].left(size) / variance;
        if (cost >= best) continue;
        best = cost;
        noise_[c] = g;
        variance_(static_cast<Index>(c)) = variance;
      }
      cost_ += best;
    }
  }

  /// Adds a channel's share of A and c.
  void put(std::size_t c, const Normal& normal, double variance, MatrixXd& a, VectorXd& right) const {
    const std::vector<Index>& set = picks_[c].set;
    for (std::size_t i = 0; i < set.size(); ++i) {
      right(set[i]) += normal.c(static_cast<Index>(i)) / variance;
      for (std::size_t j = 0; j < set.size(); ++j)
        a(set[i], set[j]) += normal.a(static_cast<Index>(i), static_cast<Index>(j)) / variance;
    }
  }

  void solve() {
    MatrixXd a = prior_;
    VectorXd right = VectorXd::Zero(prior_.rows());
    for (std::size_t c = 0; c < normals_.size(); ++c) {
      put(c, normals_[c][noise_[c]], variance_(static_cast<Index>(c)), a, right);
    }
    const Eigen::LLT<MatrixXd> factor(a);
    size_ = factor.solve(right);
    covariance_ = factor.solve(MatrixXd::Identity(a.rows(), a.cols()));
  }

  static double log_evidence(const MatrixXd& a, const VectorXd& right, VectorXd& size) {
    const Eigen::LLT<MatrixXd> factor(a);
    size = factor.solve(right);
    return 0.5 * right.dot(size) - MatrixXd(factor.matrixL()).diagonal().array().log().sum();
  }

  void judge(Index b, Fit& out) const {
    MatrixXd others_a = prior_, all_a = prior_;
    VectorXd others_c = VectorXd::Zero(prior_.rows()), all_c = others_c, size;
    double own = 0.0;
    for (std::size_t c = 0; c < normals_.size(); ++c) {
      const ChannelGram& channel = problem_.channels[c];
      const Products& block = channel.of_block(noise_[c], b);
      if (block.count == 0.0) {
        put(c, normals_[c][noise_[c]], variance_(static_cast<Index>(c)), others_a, others_c);
        put(c, normals_[c][noise_[c]], variance_(static_cast<Index>(c)), all_a, all_c);
        continue;
      }
      const Normal& all = normals_[c][noise_[c]];
      Normal part = normal_of(block, picks_[c]);
      stay(stays_, picks_[c], part);
      const Normal rest{all.a - part.a, all.c - part.c, all.square - part.square};
      const double count = channel.all[noise_[c]].count - block.count;
      const double variance =
          count > 0.0 ? bounded(c, noise_[c], rest.left(sizes_in(c)) / count) : variance_(static_cast<Index>(c));
      put(c, rest, variance, others_a, others_c);
      put(c, all, variance, all_a, all_c);
      own -= 0.5 * (block.count * std::log(kTwoPi * variance) + block.log_det + part.square / variance);
    }
    const double with = log_evidence(all_a, all_c, size);
    out.log_p(b) = own + with - log_evidence(others_a, others_c, size);
    put_left(b, size, out.left);
  }

  /// Plain sums of squares of a block beyond these sizes.
  void put_left(Index b, VectorXd size, MatrixXd& out) const {
    put_plain_starts(size);
    for (std::size_t c = 0; c < normals_.size(); ++c) {
      VectorXd in(static_cast<Index>(picks_[c].set.size()));
      for (Index i = 0; i < in.size(); ++i) in(i) = size(picks_[c].set[static_cast<std::size_t>(i)]);
      const Products& plain = problem_.channels[c].of_block(0, b);
      out(static_cast<Index>(c), b) = plain.count > 0.0 ? normal_of(plain, picks_[c]).left(in) : 0.0;
    }
  }

  const Problem& problem_;
  std::vector<Index> columns_;
  MatrixXd prior_, covariance_;
  std::vector<Picked> picks_;
  std::vector<std::vector<Normal>> normals_;  // [channel][noise]
  std::vector<std::size_t> noise_;
  std::vector<Stay> stays_;
  VectorXd variance_, size_;
  double cost_ = 0.0;  // -2 ln p of the sizes at the noise that was chosen for them
};

}  // namespace

VectorXd bounded_starts(MatrixXd normal, VectorXd right, const VectorXd& sigma) {
  const Index n = right.size();
  VectorXd out = normal.ldlt().solve(right);
  for (Index round = 0; round < n; ++round) {
    Index far = -1;
    for (Index k = 0; k < n; ++k) {
      if (std::abs(out(k)) > kFarthest * sigma(k) * (1.0 + 1e-9)) far = k;
    }
    if (far < 0) break;
    const double at = std::copysign(kFarthest * sigma(far), out(far));
    right -= at * normal.col(far);
    normal.row(far).setZero();
    normal.col(far).setZero();
    normal(far, far) = 1.0;
    right(far) = at;
    out = normal.ldlt().solve(right);
  }
  return out;
}

double slow_noise(const Problem& problem, const Fit& fit, std::size_t channel) {
  const double share = problem.channels[channel].noise[fit.noise[channel]].slow_share;
  return std::sqrt(share * fit.variance(static_cast<Index>(channel)));
}

double fast_variance(const Problem& problem, const Fit& fit, std::size_t channel) {
  const double rough = problem.channels[channel].noise[fit.noise[channel]].rough_share;  // of a mean square of one
  return (1.0 + rough) * fit.variance(static_cast<Index>(channel));
}

Fit fit_of(const Problem& problem, const std::vector<Index>& with) {
  std::vector<Index> columns = problem.nuisances;
  columns.insert(columns.end(), with.begin(), with.end());
  Fitting fitting(problem, columns);
  fitting.settle();
  return fitting.result();
}

Lead lead_of(const Fit& better, const Fit& worse) {
  const VectorXd by_block = better.log_p - worse.log_p;
  const double won = by_block.cwiseMax(0.0).sum(), lost = -by_block.cwiseMin(0.0).sum();
  Lead out;
  out.ln = by_block.sum();
  out.decisive = out.ln > kDecisive && out.ln - by_block.maxCoeff() > kDecisive && lost < kAgainst * won;
  return out;
}

}  // namespace voltlap::explain
