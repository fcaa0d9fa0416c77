// SPDX-License-Identifier: Apache-2.0
#include "race/track/import/banded_system.hpp"

#include <algorithm>
#include <cmath>

#include "core/demand.hpp"

namespace voltlap::plant {

BandedSystem::BandedSystem(std::size_t n, std::size_t half_width)
    : n_(n), half_width_(half_width), entries_(n * (half_width + 1), 0.0) {
  VOLTLAP_DEMAND(n > 0);
}

void BandedSystem::clear() { std::fill(entries_.begin(), entries_.end(), 0.0); }

bool BandedSystem::factorise() {
  const std::size_t w = half_width_;
  for (std::size_t i = 0; i < n_; ++i) {
    double* row = &entries_[i * (w + 1)];
    const std::size_t first = i > w ? i - w : 0;
    for (std::size_t j = first; j <= i; ++j) {
      const double* other = &entries_[j * (w + 1)];
      double sum = row[i - j];
      for (std::size_t k = std::max(first, j > w ? j - w : 0); k < j; ++k) sum -= row[i - k] * other[j - k];
      if (j < i) {
        row[i - j] = sum / other[0];
      } else {
        if (!(sum > 0.0)) return false;
        row[0] = std::sqrt(sum);
      }
    }
  }
  return true;
}

std::vector<double> BandedSystem::solved(std::vector<double> b) const {
  VOLTLAP_DEMAND(b.size() == n_);
  for (std::size_t i = 0; i < n_; ++i) {
    for (std::size_t k = i > half_width_ ? i - half_width_ : 0; k < i; ++k) b[i] -= lower(i, k) * b[k];
    b[i] /= lower(i, i);
  }
  for (std::size_t i = n_; i-- > 0;) {
    const std::size_t last = std::min(n_ - 1, i + half_width_);
    for (std::size_t k = i + 1; k <= last; ++k) b[i] -= lower(k, i) * b[k];
    b[i] /= lower(i, i);
  }
  VOLTLAP_DEMAND(all_finite(b));
  return b;
}

double BandedSystem::log_determinant() const {
  double sum = 0.0;
  for (std::size_t i = 0; i < n_; ++i) sum += std::log(lower(i, i));
  return 2.0 * sum;
}

void BandedSystem::invert_band() {
  inverse_.assign(entries_.size(), 0.0);
  for (std::size_t i = n_; i-- > 0;) {
    const std::size_t last = std::min(n_ - 1, i + half_width_);
    for (std::size_t j = last; j > i; --j) {
      double sum = 0.0;
      for (std::size_t k = i + 1; k <= last; ++k) sum -= lower(k, i) * inverse(k, j);
      inverse_[j * (half_width_ + 1) + (j - i)] = sum / lower(i, i);
    }
    double sum = 1.0 / lower(i, i);
    for (std::size_t k = i + 1; k <= last; ++k) sum -= lower(k, i) * inverse(k, i);
    inverse_[i * (half_width_ + 1)] = sum / lower(i, i);
  }
  VOLTLAP_DEMAND(all_finite(inverse_));
}

}  // namespace voltlap::plant
