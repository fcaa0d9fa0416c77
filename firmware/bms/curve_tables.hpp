// SPDX-License-Identifier: Apache-2.0
// The curves of a cell that the BMS is told, how many points they have, and what each of them must be.
#pragma once
#include <cstddef>
#include <cstdint>

#include "base/interpolate.hpp"
#include "base/time.hpp"
#include "base/units.hpp"
#include "bms/capacity.hpp"
#include "can_dbc/car.hpp"

namespace voltlap::bms {

inline constexpr std::size_t kMaxTablePoints = 32;
inline constexpr std::uint8_t kNoCell = 255;
static_assert(kMaxCells > 0 && kMaxCells < kNoCell, "a cell index must fit its byte on the bus");
static_assert(kMaxCells <= can::CellVoltages::kGroups * can::CellVoltages::kPerFrame &&
                  kMaxTemperatures <= can::Temperatures::kGroups * can::Temperatures::kPerFrame,
              "more than the frames of the bus carry");

/// Open-circuit voltage of one cell over state of charge; both columns strictly increasing.
struct OcvTable {
  Soc soc[kMaxTablePoints] = {};
  CellVoltage voltage[kMaxTablePoints] = {};
  std::uint8_t count = 0;
};

/// Resistance of one cell over state of charge at `reference`, and its slope with temperature:
///   R(soc, T) = R(soc) (1 + ppm_per_kelvin 1e-6 (T - reference)); a cell that is worse when cold has a negative slope
struct ResistanceTable {
  Soc soc[kMaxTablePoints] = {};
  Resistance resistance[kMaxTablePoints] = {};
  std::uint8_t count = 0;
  Temperature reference = Temperature::from_raw(250);
  std::int32_t ppm_per_kelvin = 0;
};

/// Relative change of each part of the circuit by something else than its charge [ppm per unit].
struct PartSlopes {
  std::int32_t series = 0, branch1 = 0, branch2 = 0, time1 = 0, time2 = 0;
};

/// What each part is at a temperature, of what it is at the reference [ppm].
struct PartShares {
  std::int32_t series = 1'000'000, branch1 = 1'000'000, branch2 = 1'000'000, time1 = 1'000'000, time2 = 1'000'000;
};

/// Arrhenius' law bends by a factor of ten between 0 and 40 degC: a straight line over it is right at its ends alone.
inline constexpr std::size_t kMaxWarmthPoints = 12;

/// Circuit of one cell for the filter, at the SOC and the reference temperature of its ResistanceTable. A part is
///   p(s) (1 + per_ampere 1e-6 (|I| - I_ref)) warmth(T) 1e-6
/// I held within its range, warmth straight between its points and as at the first and the last beyond them. A cell of
/// one branch has a second one of 0 ohm. Only SocMethod::kEkf reads it.
struct BranchTable {
  Resistance series[kMaxTablePoints] = {};  ///< at once
  Resistance branch1[kMaxTablePoints] = {}, branch2[kMaxTablePoints] = {};
  Duration time1[kMaxTablePoints] = {}, time2[kMaxTablePoints] = {};
  PartSlopes per_ampere{};
  Current current_reference{}, current_min{}, current_max{};
  Temperature warmth_at[kMaxWarmthPoints] = {};
  PartShares warmth[kMaxWarmthPoints] = {};
  std::uint8_t warmth_count = 1;
};

namespace check {

inline constexpr Soc kFull = Soc::from_raw(1'000'000);
inline constexpr Resistance kBranchMax = Resistance::from_raw(500'000);             // 0.5 ohm; chosen, no cell has it
inline constexpr std::int32_t kPartSlopeMaxPpm = 100'000;                           // 10 % an ampere or kelvin; chosen
// Within its range of currents a part is a tenth to 2.8 times itself; by current and temperature together less than 8
// times, which is as far as the filter's numbers go.
inline constexpr std::int64_t kPartChangeMinPpm = -900'000, kPartChangeMaxPpm = 1'800'000;
inline constexpr std::int64_t kPartShareMinPpm = 100'000, kPartShareMaxPpm = 7'900'000;
inline constexpr Temperature kWarmthStepMin = Temperature::from_raw(10);            // 1 K; chosen
inline constexpr Temperature kWarmthMin = Temperature::from_raw(-1'000);            // -100 degC; chosen
inline constexpr Temperature kWarmthMax = Temperature::from_raw(3'000);             // 300 degC; chosen
inline constexpr Duration kBranchTimeMin = Duration::from_ms(500);                  // less is over within a step
inline constexpr Duration kBranchTimeMax = Duration::from_ms(100'000'000);          // 28 h; chosen

constexpr bool points_fit(std::uint8_t count) { return count >= 2 && count <= kMaxTablePoints; }

constexpr bool spans_soc(const Soc* soc, std::uint8_t count) {
  return strictly_increasing(soc, count) && soc[0] >= Soc{} && soc[count - 1] <= kFull;
}

constexpr bool all_positive(const Resistance* resistance, std::uint8_t count) {
  for (std::uint8_t i = 0; i < count; ++i) {
    if (resistance[i] <= Resistance{}) return false;
  }
  return true;
}

constexpr bool resistances_fit(const Resistance* r, std::uint8_t count) {
  for (std::uint8_t i = 0; i < count; ++i) {
    if (r[i] < Resistance{} || r[i] > kBranchMax) return false;
  }
  return true;
}

/// At neither end of a range, `low` and `high` thousandths from the reference, does a part change too much.
constexpr bool slopes_fit(const PartSlopes& s, std::int64_t low, std::int64_t high) {
  if (high < low) return false;
  const std::int32_t slopes[] = {s.series, s.branch1, s.branch2, s.time1, s.time2};
  for (const std::int32_t slope : slopes) {
    if (slope < -kPartSlopeMaxPpm || slope > kPartSlopeMaxPpm) return false;
    const std::int64_t changes[] = {slope * low / 1'000, slope * high / 1'000};
    for (const std::int64_t change : changes) {
      if (change < kPartChangeMinPpm || change > kPartChangeMaxPpm) return false;
    }
  }
  return true;
}

/// The largest that a slope makes of a part within its range, `low` and `high` thousandths from the reference [ppm].
constexpr std::int64_t most_by_slope(std::int32_t slope, std::int64_t low, std::int64_t high) {
  const std::int64_t a = slope * low / 1'000, b = slope * high / 1'000;
  return 1'000'000 + (a > b ? a : b);
}

/// `low` and `high`: the range of the current, thousandths from its reference.
constexpr bool warmth_fits(const BranchTable& b, std::int64_t low, std::int64_t high) {
  if (b.warmth_count < 1 || b.warmth_count > kMaxWarmthPoints) return false;
  const PartSlopes& by = b.per_ampere;
  const std::int64_t most[] = {most_by_slope(by.series, low, high), most_by_slope(by.branch1, low, high),
                               most_by_slope(by.branch2, low, high), most_by_slope(by.time1, low, high),
                               most_by_slope(by.time2, low, high)};
  for (std::uint8_t i = 0; i < b.warmth_count; ++i) {
    if (b.warmth_at[i] < kWarmthMin || b.warmth_at[i] > kWarmthMax) return false;
    if (i > 0 && b.warmth_at[i] - b.warmth_at[i - 1] < kWarmthStepMin) return false;
    const PartShares& w = b.warmth[i];
    const std::int64_t shares[] = {w.series, w.branch1, w.branch2, w.time1, w.time2};
    for (std::size_t k = 0; k < 5; ++k) {
      if (shares[k] < kPartShareMinPpm || shares[k] * most[k] / 1'000'000 > kPartShareMaxPpm) return false;
    }
  }
  return true;
}

constexpr bool times_fit(const Duration* t, std::uint8_t count) {
  for (std::uint8_t i = 0; i < count; ++i) {
    if (t[i] < kBranchTimeMin || t[i] > kBranchTimeMax) return false;
  }
  return true;
}

}  // namespace check

}  // namespace voltlap::bms
