// SPDX-License-Identifier: Apache-2.0
// A symmetric positive definite system whose entries lie in a band about the diagonal: A = L L^T in O(n w^2).
//
//   L_jj^2 = A_jj - sum L_jk^2,  L_ij = (A_ij - sum L_ik L_jk) / L_jj        Cholesky, within the band
//   Z = A^-1 on the band, from the last row upwards, without the rest of Z:   Takahashi, Fagan and Chen, 1973
#pragma once
#include <cstddef>
#include <vector>

namespace voltlap::plant {

class BandedSystem {
 public:
  /// `n` unknowns; entries A(i, j) are 0 beyond |i - j| <= `half_width`.
  BandedSystem(std::size_t n, std::size_t half_width);

  void clear();
  /// Adds to A(i, j) and A(j, i), which are one.
  void add(std::size_t i, std::size_t j, double value) {
    if (i < j) add(j, i, value);
    else entries_[i * (half_width_ + 1) + (i - j)] += value;
  }
  /// Factorises what was added; false when it is not positive definite.
  [[nodiscard]] bool factorise();
  /// A x = b, after `factorise`.
  [[nodiscard]] std::vector<double> solved(std::vector<double> b) const;
  /// log det A, after `factorise`.
  [[nodiscard]] double log_determinant() const;
  /// The entries of A^-1 within the band, after `factorise`; read them by `inverse(i, j)`.
  void invert_band();
  [[nodiscard]] double inverse(std::size_t i, std::size_t j) const {
    return i < j ? inverse(j, i) : inverse_[i * (half_width_ + 1) + (i - j)];
  }
  [[nodiscard]] std::size_t size() const { return n_; }

 private:
  [[nodiscard]] double lower(std::size_t i, std::size_t j) const { return entries_[i * (half_width_ + 1) + (i - j)]; }

  std::size_t n_, half_width_;
  std::vector<double> entries_, inverse_;  ///< row by row: (i, i), (i, i - 1) ... (i, i - half_width)
};

}  // namespace voltlap::plant
