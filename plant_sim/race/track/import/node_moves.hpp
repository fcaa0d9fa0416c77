// SPDX-License-Identifier: Apache-2.0
// The moves of a chain's nodes that lie best between its points and a curvature that changes little: weighted linear
// least squares about where the nodes are.
#pragma once
#include <vector>

#include "race/track/import/banded_system.hpp"
#include "race/track/import/node_chain.hpp"

namespace voltlap::plant {

class NodeMoves {
 public:
  /// `chain` is linearised and must outlive it.
  explicit NodeMoves(const NodeChain& chain);

  /// `weights` of the curvature changes against the points' 1; `damping` holds the nodes where they are. False when the
  /// weights are too large for double precision.
  [[nodiscard]] bool try_solve(const std::vector<double>& weights, double damping = 0.0);
  /// With as little damping more as double precision asks for.
  void solve(const std::vector<double>& weights, double damping = 0.0);
  [[nodiscard]] const std::vector<double>& moves() const { return moves_; }
  [[nodiscard]] double log_determinant() const { return system_.log_determinant(); }
  /// Sum of squares of what is left between points and line.
  [[nodiscard]] double squares_left() const;

  /// Makes `variance` available.
  void find_variances() { system_.invert_band(); }
  /// Of a function of the moves, for points of noise 1.
  template <std::size_t N>
  [[nodiscard]] double variance(const NodeFunction<N>& f) const {
    double sum = 0.0;
    for (std::size_t a = 0; a < N; ++a) {
      for (std::size_t b = 0; b < N; ++b) {
        sum += f.slope[a] * f.slope[b] * system_.inverse(row(f.node[a]), row(f.node[b]));
      }
    }
    return sum;
  }

 private:
  /// A closed chain is folded flat, 0, n - 1, 1, n - 2 ..., so that neighbours stay within the band.
  [[nodiscard]] std::size_t row(std::size_t node) const {
    const std::size_t n = chain_.size();
    if (!chain_.closed()) return node;
    return node < (n + 1) / 2 ? 2 * node : 2 * (n - 1 - node) + 1;
  }
  template <std::size_t N>
  void add(const NodeFunction<N>& f, double weight) {
    for (std::size_t a = 0; a < N; ++a) {
      right_[row(f.node[a])] -= weight * f.slope[a] * f.value;
      for (std::size_t b = 0; b <= a; ++b) {
        system_.add(row(f.node[a]), row(f.node[b]), weight * f.slope[a] * f.slope[b]);
      }
    }
  }

  const NodeChain& chain_;
  BandedSystem system_;
  std::vector<double> right_, moves_;
};

}  // namespace voltlap::plant
