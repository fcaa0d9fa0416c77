// SPDX-License-Identifier: Apache-2.0
#include "discrepancy/noise.hpp"

#include <algorithm>
#include <cmath>

namespace voltlap::plant {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// Minus twice the log-likelihood with the scale profiled out, and that scale squared.
struct Profile {
  double value, scale2;
};

Profile profile(const VectorXd& time_s, const std::vector<VectorXd>& residuals, double share, double tau_s) {
  double square = 0.0, determinant = 0.0, count = 0.0;
  for (const VectorXd& residual : residuals) {
    const std::vector<bool> valid = finite_rows(residual);
    const Whitener whitener(time_s, valid, {std::sqrt(1.0 - share), std::sqrt(share), tau_s});
    square += whitener.apply(residual).squaredNorm();
    determinant += whitener.log_determinant();
    count += static_cast<double>(std::count(valid.begin(), valid.end(), true));
  }
  const double scale2 = std::max(square / std::max(1.0, count), 1e-300);
  return {count * std::log(scale2) + determinant, scale2};
}

}  // namespace

std::vector<bool> finite_rows(const VectorXd& values) {
  std::vector<bool> out(static_cast<std::size_t>(values.size()));
  for (Index row = 0; row < values.size(); ++row) out[static_cast<std::size_t>(row)] = std::isfinite(values(row));
  return out;
}

Whitener::Whitener(const VectorXd& time_s, std::vector<bool> valid, const Noise& noise)
    : valid_(std::move(valid)), phi_(time_s.size()), gain_(time_s.size()), scale_(time_s.size()) {
  const double power = noise.coloured * noise.coloured, white = noise.white * noise.white;
  double variance = power;
  for (Index row = 0; row < time_s.size(); ++row) {
    const double phi = row == 0 ? 0.0 : std::exp(-(time_s(row) - time_s(row - 1)) / noise.tau_s);
    variance = phi * phi * variance + power * (1.0 - phi * phi);
    phi_(row) = phi;
    const bool valid_row = valid_[static_cast<std::size_t>(row)];
    const double innovation = variance + white;
    gain_(row) = valid_row ? variance / innovation : 0.0;
    scale_(row) = valid_row ? 1.0 / std::sqrt(innovation) : 0.0;
    if (valid_row) {
      log_determinant_ += std::log(innovation);
      variance *= 1.0 - gain_(row);
    }
  }
}

VectorXd Whitener::apply(const VectorXd& values) const {
  VectorXd out(values.size());
  double state = 0.0;
  for (Index row = 0; row < values.size(); ++row) {
    state *= phi_(row);
    if (!valid_[static_cast<std::size_t>(row)]) {
      out(row) = 0.0;
      continue;
    }
    const double innovation = values(row) - state;
    out(row) = innovation * scale_(row);
    state += gain_(row) * innovation;
  }
  return out;
}

Noise fit_noise(const VectorXd& time_s, const std::vector<VectorXd>& residuals, double least) {
  constexpr double kShares[] = {0.0, 0.1, 0.3, 0.6, 0.85, 0.95, 0.99, 0.998};
  constexpr double kTaus[] = {0.4, 1.5, 5.0, 20.0, 80.0, 300.0};
  Profile best{1e300, 1.0};
  double share = 0.0, tau = 10.0;
  for (const double tried : kShares) {
    for (const double tried_tau : kTaus) {
      const Profile p = profile(time_s, residuals, tried, tried_tau);
      if (p.value < best.value) {
        best = p;
        share = tried;
        tau = tried_tau;
      }
      if (tried == 0.0) break;
    }
  }
  const double scale = std::sqrt(best.scale2);
  return {std::max(least, scale * std::sqrt(1.0 - share)), scale * std::sqrt(share), tau};
}

}  // namespace voltlap::plant
