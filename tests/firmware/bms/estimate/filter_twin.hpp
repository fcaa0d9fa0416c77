// SPDX-License-Identifier: Apache-2.0
// The cell filter in double precision: the equations of cell_filter.hpp as matrices, with the exponential in the place
// of its series. It shares the curves of a CellModel with the integers, their bounds, and no line of code.
#pragma once
#include <array>
#include <cmath>
#include <utility>

#include "bms/estimate/cell_filter.hpp"

namespace voltlap::bms::test {

class FilterTwin {
 public:
  static constexpr std::size_t kStates = 5;  // s, v1, v2, rho, fade
  using Vector = std::array<double, kStates>;
  using Matrix = std::array<Vector, kStates>;

  explicit FilterTwin(const CellModel& model) : model_(model) {}

  Vector x{0.0, 0.0, 0.0, 1.0, 0.0};
  Matrix p{};
  double apart = 0.0;
  bool from_record = false;

  void take(const CellFilter& f) {
    x = {unit(f.s), unit(f.v1), unit(f.v2), unit(f.rho), unit(f.fade)};
    apart = unit(f.apart);
    from_record = f.from_record;
    const CellCovariance& c = f.p;
    const std::int32_t raw[kStates][kStates] = {{c.ss, c.s1, c.s2, c.sr, c.sf},
                                                {c.s1, c.v11, c.v12, c.v1r, c.v1f},
                                                {c.s2, c.v12, c.v22, c.v2r, c.v2f},
                                                {c.sr, c.v1r, c.v2r, c.rr, c.rf},
                                                {c.sf, c.v1f, c.v2f, c.rf, c.ff}};
    for (std::size_t i = 0; i < kStates; ++i) {
      for (std::size_t k = 0; k < kStates; ++k) p[i][k] = std::ldexp(raw[i][k], -kVarianceBits);
    }
  }

  void predict(const PartFactors& warm, const FilterInterval& interval) {
    const Circuit c = circuit(x[0]);
    const PartFactors by = factors_of(model_.by_current, std::abs(interval.mean_ma));
    const double ma = interval.mean_ma, dt = interval.elapsed_ms, drawn = unit(interval.drawn);
    const double tau1 = unit(by.time1) * unit(warm.time1), tau2 = unit(by.time2) * unit(warm.time2);
    const double g1 = gain(c.rate1 * dt / tau1), g2 = gain(c.rate2 * dt / tau2);
    const double e1 = bounded(c.r1 * ma * unit(by.r1) * unit(warm.r1), 8.0);
    const double e2 = bounded(c.r2 * ma * unit(by.r2) * unit(warm.r2), 8.0);
    Matrix f{};
    for (std::size_t i = 0; i < kStates; ++i) f[i][i] = 1.0;
    f[0][4] = -drawn;
    f[1][1] = 1.0 - g1, f[1][3] = g1 * bounded(e1, 1.0);
    f[2][2] = 1.0 - g2, f[2][3] = g2 * bounded(e2, 1.0);
    x = {x[0] - (1.0 + x[4]) * drawn, x[1] + g1 * (x[3] * e1 - x[1]), x[2] + g2 * (x[3] * e2 - x[2]), x[3], x[4]};
    p = times(times(f, p), transposed(f));
    constexpr Vector kGrowth{0, 200, 200, 430, 4};  // cell_filter.cpp
    hold();
    if (p[0][0] < 0.1) p[0][0] += std::abs(drawn) / 8'192.0;
    for (std::size_t i = 0; i < kStates; ++i) {
      if (p[i][i] < 0.1) p[i][i] += std::ldexp(kGrowth[i], -kVarianceBits) * dt / 100.0;
    }
  }

  void update(const PartFactors& warm, const FilterReading& reading) {
    const auto [ocv, slope] = open_circuit(x[0]);
    const double factor = unit(factors_of(model_.by_current, std::abs(reading.current_ma)).r0) * unit(warm.r0);
    const double drop = bounded(circuit(x[0]).r0 * factor * reading.current_ma, 4.0);
    const double y = bounded(4e-4 * reading.voltage.raw() - ocv + x[1] + x[2] + x[3] * drop, 1.0);
    const Vector h{slope, -1.0, -1.0, -drop, 0.0};
    Vector ph{};
    const double beyond = std::max(0.0, std::abs(apart) - 0.024);
    double s = 0.12 * 0.12 + 0.04 * drop * drop + 128.0 * beyond * beyond, seen = 0.0;
    for (std::size_t i = 0; i < kStates; ++i) {
      for (std::size_t k = 0; k < kStates; ++k) ph[i] += p[i][k] * h[k];
    }
    for (std::size_t i = 0; i < kStates; ++i) seen += h[i] * ph[i];
    s += std::max(0.0, seen);
    if (std::exchange(from_record, false) && y * y > 4.0 * s) {
      p[0][0] = 0.25 * 0.25;
      return;
    }
    apart += (y - apart) / 128.0;
    for (std::size_t i = 0; i < kStates; ++i) x[i] += ph[i] * y / s;
    for (std::size_t i = 0; i < kStates; ++i) {
      for (std::size_t k = 0; k < kStates; ++k) p[i][k] -= ph[i] * ph[k] / s;
    }
    hold();
  }

 private:
  struct Circuit {
    double r0, r1, r2, rate1, rate2;
  };

  static double unit(std::int32_t raw) { return std::ldexp(raw, -kUnitBits); }
  static double bounded(double value, double most) { return std::clamp(value, -most, most); }
  static double gain(double x) { return -std::expm1(-std::min(x, 0.49)); }

  [[nodiscard]] Circuit circuit(double soc) const {
    const double at = std::clamp(soc, 0.0, 1.0) * kCircuitSteps;
    const auto k = std::min(static_cast<std::size_t>(at), kCircuitSteps - 1);
    const double along = at - static_cast<double>(k);
    const CircuitPoint &a = model_.circuit[k], &b = model_.circuit[k + 1];
    const auto read = [along](std::int32_t low, std::int32_t high, int bits) {
      return std::ldexp(low + (static_cast<double>(high) - low) * along, -bits);
    };
    constexpr int kOhm = kUnitBits + kOhmBits;
    return {read(a.r0, b.r0, kOhm), read(a.r1, b.r1, kOhm), read(a.r2, b.r2, kOhm),
            read(a.rate1, b.rate1, kRateBits), read(a.rate2, b.rate2, kRateBits)};
  }

  [[nodiscard]] std::pair<double, double> open_circuit(double soc) const {
    std::size_t i = 0;
    while (i + 1 < model_.intervals && soc >= unit(model_.ocv_soc[i + 1])) ++i;
    const double slope = std::ldexp(model_.ocv_slope[i], -kSlopeBits);
    return {std::ldexp(model_.ocv[i], -kVoltageBits) + slope * (soc - unit(model_.ocv_soc[i])), slope};
  }

  static Matrix times(const Matrix& a, const Matrix& b) {
    Matrix out{};
    for (std::size_t i = 0; i < kStates; ++i) {
      for (std::size_t k = 0; k < kStates; ++k) {
        for (std::size_t j = 0; j < kStates; ++j) out[i][j] += a[i][k] * b[k][j];
      }
    }
    return out;
  }
  static Matrix transposed(const Matrix& a) {
    Matrix out{};
    for (std::size_t i = 0; i < kStates; ++i) {
      for (std::size_t k = 0; k < kStates; ++k) out[k][i] = a[i][k];
    }
    return out;
  }

  /// The bounds of the state and of the variances.
  void hold() {
    constexpr double kLeast = 4'096.0 / 4'294'967'296.0;
    x = {std::clamp(x[0], -0.05, 1.05), bounded(x[1], 6.0), bounded(x[2], 6.0), std::clamp(x[3], 0.2, 5.0),
         std::clamp(x[4], -0.25, 0.5)};
    for (std::size_t i = 0; i < kStates; ++i) p[i][i] = std::max(p[i][i], kLeast);
  }

  const CellModel& model_;
};

}  // namespace voltlap::bms::test
