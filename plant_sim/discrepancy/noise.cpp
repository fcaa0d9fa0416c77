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

/// How the variance is made up, before its scale.
struct Shape {
  double slow, tau_s;  ///< share of the coloured part, its time
  double current;      ///< share of the current sensor in the rest
};

double mean_square_ohm(const std::vector<NoiseSample>& samples) {
  double square = 0.0, count = 0.0;
  for (const NoiseSample& s : samples) {
    square += s.ohm.squaredNorm();
    count += static_cast<double>(s.ohm.size());
  }
  return count > 0.0 ? square / count : 0.0;
}

Noise noise_of_shape(const Shape& shape, double scale, double square_ohm) {
  Noise out;
  out.white = scale * std::sqrt((1.0 - shape.slow) * (1.0 - shape.current));
  out.coloured = scale * std::sqrt(shape.slow);
  out.tau_s = shape.tau_s;
  out.current_a = square_ohm > 0.0 ? scale * std::sqrt((1.0 - shape.slow) * shape.current / square_ohm) : 0.0;
  return out;
}

Profile profile(const std::vector<NoiseSample>& samples, const Shape& shape, double square_ohm) {
  double square = 0.0, determinant = 0.0, count = 0.0;
  for (const NoiseSample& sample : samples) {
    const std::vector<bool> valid = finite_rows(sample.residual);
    const Whitener whitener(*sample.time_s, valid, noise_of_shape(shape, 1.0, square_ohm), sample.ohm);
    square += whitener.apply(sample.residual).squaredNorm();
    determinant += whitener.log_determinant();
    count += static_cast<double>(std::count(valid.begin(), valid.end(), true));
  }
  const double scale2 = std::max(square / std::max(1.0, count), 1e-300);
  return {count * std::log(scale2) + determinant, scale2};
}

/// Coloured part of a time `longer` times as long, that scatters from row to row `more` times as much: what the data
/// tell of both hardly depends on each other.
Shape moved(const Shape& shape, double longer, double more, double longest_s) {
  constexpr double kShortest = 0.2;  // s
  Shape out = shape;
  out.tau_s = std::clamp(shape.tau_s * longer, kShortest, longest_s);
  const double ratio = shape.slow / (1.0 - shape.slow) * more * out.tau_s / shape.tau_s;
  out.slow = ratio / (1.0 + ratio);
  return out;
}

}  // namespace

std::vector<bool> finite_rows(const VectorXd& values) {
  std::vector<bool> out(static_cast<std::size_t>(values.size()));
  for (Index row = 0; row < values.size(); ++row) out[static_cast<std::size_t>(row)] = std::isfinite(values(row));
  return out;
}

Whitener::Whitener(const VectorXd& time_s, std::vector<bool> valid, const Noise& noise, const VectorXd& ohm)
    : valid_(std::move(valid)), phi_(time_s.size()), gain_(time_s.size()), scale_(time_s.size()) {
  const double power = noise.coloured * noise.coloured, white = noise.white * noise.white;
  double variance = power;
  for (Index row = 0; row < time_s.size(); ++row) {
    const double phi = row == 0 ? 0.0 : std::exp(-(time_s(row) - time_s(row - 1)) / noise.tau_s);
    variance = phi * phi * variance + power * (1.0 - phi * phi);
    phi_(row) = phi;
    const bool valid_row = valid_[static_cast<std::size_t>(row)];
    const double sensor = ohm.size() > 0 ? noise.current_a * ohm(row) : 0.0;
    const double innovation = variance + white + sensor * sensor;
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

Noise fit_noise(const std::vector<NoiseSample>& samples, double least, NoiseSearch search, double longest_s) {
  constexpr double kShares[] = {0.0, 0.1, 0.3, 0.6, 0.85, 0.95, 0.99, 0.998};
  constexpr double kTaus[] = {0.4, 1.5, 5.0, 20.0, 80.0, kLongestMemory};
  constexpr double kCurrentShares[] = {0.25, 0.5, 0.75, 0.95}, kFinest = 1.15;
  const double square_ohm = mean_square_ohm(samples);
  Profile best{1e300, 1.0};
  Shape shape{0.0, 10.0, 0.0};
  const auto consider = [&](const Shape& tried) {
    const Profile p = profile(samples, tried, square_ohm);
    if (p.value >= best.value) return;
    best = p;
    shape = tried;
  };
  for (const double point : kTaus) {
    const double tau = std::min(point, longest_s);
    for (const double share : kShares) {
      if (share > 0.0 || tau == kTaus[0]) consider({share, tau, 0.0});
    }
    if (point >= longest_s) break;
  }
  const Shape first = shape;
  for (const double share : kCurrentShares) {
    if (square_ohm > 0.0) consider({first.slow, first.tau_s, share});
  }
  if (shape.slow > 0.0 && search == NoiseSearch::kBetween) {
    for (double step = 2.0; step > kFinest; step = std::sqrt(step)) {
      for (const auto& [longer, more] : {std::pair{step, 1.0}, {1.0 / step, 1.0}, {1.0, step}, {1.0, 1.0 / step}}) {
        consider(moved(shape, longer, more, longest_s));
      }
    }
  }
  Noise out = noise_of_shape(shape, std::sqrt(best.scale2), square_ohm);
  out.white = std::max(least, out.white);
  return out;
}

}  // namespace voltlap::plant
