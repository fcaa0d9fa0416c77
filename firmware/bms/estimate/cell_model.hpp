// SPDX-License-Identifier: Apache-2.0
// A cell's curves as its filter reads them, in the filter's units, made once from the configuration.
//
//   voltages   4 V in the filter's one: q = 4 V / volt, so that voltage, charge and scale have like variances
//   s          SOC                                  2^-28, counts beyond 0 and 1
//   OCV(s)     straight between the points of Config::ocv, beyond its ends with the slope there
//   R0 R1 R2   at 33 points of SOC
//   1/tau_k    at the same points
#pragma once
#include <cstddef>
#include <cstdint>

#include "base/fixed_point.hpp"
#include "bms/config.hpp"

namespace voltlap::bms {

inline constexpr int kUnitBits = 28;                          // of s, q, rho and the gains
inline constexpr std::int32_t kUnit = 1 << kUnitBits;
inline constexpr int kVoltageBits = 26;                       // of whole cell voltages, to 8 V
inline constexpr int kSlopeBits = 26;                         // of dq/ds
inline constexpr std::int32_t kSlopeMax = 24 << kSlopeBits;   // 6 V over the whole charge; steeper counts as that
inline constexpr int kOhmBits = 8;                            // of q / mA beside the unit's
inline constexpr int kRateBits = 38;                          // of 1/ms
inline constexpr int kLawBits = 36;                           // of a part's change by a count
inline constexpr std::size_t kCircuitSteps = 32;
inline constexpr int kCircuitStepBits = kUnitBits - 5;        // a step of SOC
static_assert(kCircuitSteps << kCircuitStepBits == static_cast<std::size_t>(kUnit));

/// One point of the circuit's curves, or what is read between two.
struct CircuitPoint {
  std::int32_t r0 = 0, r1 = 0, r2 = 0;  ///< [q 2^-36 / mA]
  std::int32_t rate1 = 0, rate2 = 0;    ///< [2^-38 / ms]
};

/// What a current or a temperature makes of each part [2^-28 of the part].
struct PartFactors {
  std::int32_t r0 = kUnit, r1 = kUnit, r2 = kUnit, time1 = kUnit, time2 = kUnit;
};

/// The current, that the parts change with: a part is 1 + per_count (x - reference) of itself, x held within the range.
struct PartLaw {
  std::int32_t low = 0, high = 0, reference = 0;  ///< [mA]
  PartFactors per_count{0, 0, 0, 0, 0};           ///< [2^-36 / count]
};

/// What the parts are at some temperatures: straight between them, beyond their ends as there.
struct WarmthCurve {
  std::int32_t at[kMaxWarmthPoints] = {};      ///< [0.1 degC]
  PartFactors factor[kMaxWarmthPoints] = {};
  PartFactors slope[kMaxWarmthPoints] = {};    ///< to the next [2^-36 / count], at most 31 % a kelvin
  std::uint8_t points = 1;
  [[nodiscard]] std::int32_t low() const { return at[0]; }
  [[nodiscard]] std::int32_t high() const { return at[points - 1]; }
};

struct CellModel {
  std::int32_t ocv_soc[kMaxTablePoints] = {};      ///< [2^-28]
  std::int32_t ocv[kMaxTablePoints] = {};          ///< [q 2^-26]
  std::int32_t ocv_slope[kMaxTablePoints] = {};    ///< [q 2^-26] of the interval that begins here
  std::uint8_t intervals = 0;
  CircuitPoint circuit[kCircuitSteps + 1] = {};
  std::uint8_t points = 0;                         ///< of the circuit that are made
  PartLaw by_current{};
  WarmthCurve by_temperature{};
};

/// In place: a processor's stack has no room for another. A part of it with every call, as much as a step has time for:
/// true when the model is whole.
[[nodiscard]] bool grow_model(const Config& config, CellModel& model);
/// All of it at once.
void make_model(const Config& config, CellModel& model);

struct OcvNow {
  std::int32_t voltage, slope;
};

/// `interval`: where the last look-up was; the search begins there, and it is left where this one is.
[[nodiscard]] OcvNow ocv_at(const CellModel& model, std::int32_t soc, std::uint8_t& interval);
/// All but R0, and R0 alone [q 2^-36 / mA].
[[nodiscard]] CircuitPoint branches_at(const CellModel& model, std::int32_t soc);
[[nodiscard]] std::int32_t series_at(const CellModel& model, std::int32_t soc);
[[nodiscard]] PartFactors factors_of(const PartLaw& law, std::int32_t counts);
[[nodiscard]] PartFactors factors_of(const WarmthCurve& curve, std::int32_t counts);
/// By how much each part changes with a count, there and above.
[[nodiscard]] const PartFactors& slope_of(const WarmthCurve& curve, std::int32_t counts);
/// How far a quantity is above the law's reference, and what that makes of a part.
[[nodiscard]] constexpr std::int32_t above_reference(const PartLaw& law, std::int32_t counts) {
  return (counts < law.low ? law.low : (counts > law.high ? law.high : counts)) - law.reference;
}
[[nodiscard]] constexpr std::int32_t factor_of(std::int32_t per_count, std::int32_t above) {
  return kUnit + scaled(per_count, above, kLawBits - kUnitBits);
}

/// A reading in the filter's unit [q 2^-26].
[[nodiscard]] constexpr std::int32_t filter_voltage(CellVoltage v) {
  constexpr std::int64_t kPerStep = 879'609'302;  // 4 x 0.1 mV x 2^26, in 2^-15
  return scaled(static_cast<std::int32_t>(kPerStep), v.raw(), 15);  // whatever the bus can say fits
}
[[nodiscard]] constexpr std::int32_t filter_soc(Soc soc) {
  return saturated32(shifted(std::int64_t{soc.raw()} * 281'474'977, 20));  // 2^28 / 1e6 in 2^-20
}
/// Within 0 and 1.
[[nodiscard]] constexpr Soc reported_soc(std::int64_t s) {
  const std::int64_t inside = s < 0 ? 0 : (s > kUnit ? kUnit : s);
  return Soc::from_raw(static_cast<std::int32_t>(shifted(inside * 1'000'000, kUnitBits)));
}
/// Volts that a resistance takes [q 2^-28], at most 2 V.
[[nodiscard]] constexpr std::int32_t drop_of(std::int32_t ohm, std::int32_t ma) { return product(ohm, ma, kOhmBits); }

}  // namespace voltlap::bms
