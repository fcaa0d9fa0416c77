// SPDX-License-Identifier: Apache-2.0
// The extended Kalman filter of one cell: charge, the voltages of two RC branches, what its resistances are of those in
// the table, and how much sooner it is empty than the count says.
//
//   x = (s, v1, v2, rho, f)   s SOC, v_k branch voltages, rho scale of R0, R1 and R2 alike, 1 + f the configured
//                             capacity over the cell's own, in ampere-hours as the sensor measures them
//   predict   s   -= (1 + f) dq / C
//             v_k += g_k (rho R_k I - v_k)         g_k = 1 - exp(-dt / tau_k), I the mean current since the last step
//             P    = F P F' + Q                    F = 1 but F_kk = 1 - g_k, F_k,rho = g_k R_k I, F_s,f = -dq / C
//   update    y    = V - OCV(s) + v1 + v2 + rho R0 I       I the current when V was read
//             H    = (dOCV/ds, -1, -1, -R0 I, 0)
//             S    = H P H' + r,   r = sigma^2 + (alpha R0 I)^2 + beta max(0, |m| - m0)^2, m the mean of 128 y
//             x   += P H' y / S,   P -= P H' H P / S
// r is not the noise of the reading (1.5 mV) but what the circuit does not say of a cell, seen often: an error that
// lasts for seconds is told at every step anew, and must not be believed at every step anew. What the circuit is off by
// for longer m shows: readings of a cell that the tables do not describe are believed the less, and the count the more.
// f is the error of the sensor's gain, of the capacity and, while the current is about the same, of an offset that was
// not seen at rest: they cannot be told apart, and at rest f changes nothing, as a bias in amperes would.
// BMS-081: a twin in double precision stands beside it in the tests.
// Source: Plett, Extended Kalman filtering for battery management systems, J. Power Sources 134, 2004.
// Units: cell_model.hpp; P in 2^-32 of their products. R0 .. R2 are those of
// the table at s, times what temperature and current make of them.
#pragma once
#include <cstdint>

#include "bms/estimate/cell_model.hpp"

namespace voltlap::bms {

inline constexpr int kVarianceBits = 32;

/// Above the diagonal; s1: of s and v1, and so on; r: rho, f: fade.
struct CellCovariance {
  std::int32_t ss, s1, s2, sr, v11, v12, v1r, v22, v2r, rr;
  std::int32_t sf, v1f, v2f, rf, ff;
};

struct CellFilter {
  std::int32_t s = 0, v1 = 0, v2 = 0, rho = kUnit, fade = 0;  ///< [2^-28]
  CellCovariance p{};
  std::int32_t miss = 0;      ///< mean innovation of the last readings [q 2^-28]
  std::int32_t apart = 0;     ///< of the last 128
  std::uint8_t interval = 0;  ///< of the OCV table, where the last search ended
  bool from_record = false;   ///< and no reading has been held against it yet
};

// BMS-084, BMS-086
/// Bounds of the state. Beyond the ends of the charge a table says little; the count goes on as far as a capacity may
/// be wrong, and is back as soon as the voltage says so.
inline constexpr std::int32_t kSocLow = -kUnit / 20, kSocHigh = kUnit + kUnit / 20;       // 5 points
inline constexpr std::int32_t kScaleLow = kUnit / 5, kScaleHigh = 5 * kUnit;              // chosen: an aged cell has 3
inline constexpr std::int32_t kFadeLow = -kUnit / 4, kFadeHigh = kUnit / 2;               // 133 to 67 % of the capacity
inline constexpr std::int32_t kBranchMost = 6 * kUnit;                                   // 1.5 V

/// Standard deviations at the start: a variance [2^-32] of each.
struct CellDoubt {
  std::int32_t s, v1, v2, rho, fade;
};

/// All covariances zero but the variances.
void begin_filter(const CellDoubt& doubt, CellFilter& filter);

inline constexpr std::int32_t kElapsedMost_ms = 1'000;

/// What flowed since the last step.
struct FilterInterval {
  std::int32_t elapsed_ms = 0;  ///< 1 .. kElapsedMost_ms
  std::int32_t drawn = 0;       ///< of the configured capacity [2^-28]
  std::int32_t mean_ma = 0;
};
/// `warm`: what the temperature makes of the parts.
void predict_cell(const CellModel& model, const PartFactors& warm, const FilterInterval& interval, CellFilter& filter);

struct FilterReading {
  CellVoltage voltage{};
  std::int32_t current_ma = 0;
};
void update_cell(const CellModel& model, const PartFactors& warm, const FilterReading& reading, CellFilter& filter);

}  // namespace voltlap::bms
