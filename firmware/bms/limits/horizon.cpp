// SPDX-License-Identifier: Apache-2.0
#include "bms/limits/horizon.hpp"

#include "base/require.hpp"
#include "bms/estimate/branch_gain.hpp"

namespace voltlap::bms {
namespace {

constexpr int kShareBits = 16;                   // of Horizon::share beside the charge's own
constexpr int kFallBits = kUnitBits + kOhmBits;  // of CellEnd::fall
constexpr int kRiseBits = 36;                    // of HorizonHeat::rise
constexpr int kFineBits = 5;                     // of a rise beside 0.1 K
constexpr std::int32_t kRiseMost = 1'000 << kFineBits;  // 100 K
constexpr std::int32_t kLeastFactor = kUnit / 10;
constexpr int kNewtonLooks = 8, kMostLooks = 20;  // chosen; four are rare, and what they do not find is halved
constexpr int kCloseBits = 8;                     // a step of less than 2^-8 of the current is the last
constexpr std::int32_t kCloseMa = 5;
constexpr std::int64_t kCloseMargin = 268'000;       // [q 2^-26] and 1 mV, where a curve bends
constexpr std::int32_t kMarginMost = (1 << 28) - 1;  // [q 2^-26] 1 V: more makes no larger step

/// `low`, should the two have crossed.
std::int32_t held(std::int64_t x, std::int32_t low, std::int32_t high) {
  return static_cast<std::int32_t>(max(min(x, std::int64_t{high}), std::int64_t{low}));
}

/// The same of 32 bits.
std::int32_t within(std::int32_t x, std::int32_t low, std::int32_t high) {
  return max(min(x, high), low);
}
std::int32_t inside_charge(std::int32_t s) { return within(s, kSocLow, kSocHigh); }

std::int32_t both(std::int32_t by_current, std::int32_t warm) { return scaled(by_current, warm, kUnitBits); }

/// What temperature and current make of a resistance, and what they make of its drop's growth with the current: R(I) I
/// grows by R + I dR/dI.
struct Law {
  std::int32_t itself, growth;  ///< [2^-28]
};
/// Where a current is on its law.
struct OnLaw {
  std::int32_t above;    ///< the reference
  std::int32_t bending;  ///< its size where the law bends, else 0
};
OnLaw on_law(const PartLaw& law, std::int32_t size) {
  return {above_reference(law, size), law.low < size && size < law.high ? size : 0};
}
inline Law law_of(std::int32_t per_count, const OnLaw& at, std::int32_t warm) {
  const std::int32_t by = factor_of(per_count, at.above);
  return {both(by, warm), both(by + scaled(per_count, at.bending, kLawBits - kUnitBits), warm)};
}

/// rho R, at most an ohm: with what the laws make of it, less than 8 times, it fits.
std::int32_t own_ohm(std::int32_t table, std::int32_t rho) {
  constexpr std::int32_t kMost = 1 << 28;  // [q 2^-36 / mA] 0.98 ohm
  return min(scaled(table, rho, kUnitBits), kMost);
}

/// R I [q 2^-26], within 4 V: more than a cell has.
std::int32_t wide_drop(std::int32_t ohm, std::int32_t ma) {
  constexpr std::int32_t kMost = 1 << 30;
  return held((std::int64_t{ohm} * ma) >> (kOhmBits + kUnitBits - kVoltageBits), -kMost, kMost);
}

struct BranchPart {
  std::int32_t ohm, rate;  ///< of the table at this charge
  Law law;
  std::int32_t time;       ///< what temperature and current make of it
  std::int32_t ohm_change, time_change;  ///< by a count of heat [2^-36]
};

struct BranchEnd {
  std::int32_t kept, made;  ///< what is left of now's, and what the current has made [q 2^-26]
  std::int32_t warms;       ///< of both: a slow branch stores most of what it takes
  std::int32_t change;      ///< of what the current has made, by a count of heat [2^-36]
  std::int32_t fall;        ///< [q 2^-36 / mA]
};

BranchEnd branch_end(const HorizonCell& cell, const BranchPart& b, std::int32_t v, std::int32_t ma) {
  constexpr std::int32_t kOne = 1 << kLongGainBits;
  const std::int32_t ms = cell.horizon.ms;
  const std::int32_t gain = ms == 0 ? kOne : long_gain_of(slowed(b.rate, b.time), ms);
  const std::int32_t ohm = own_ohm(b.ohm, cell.filter.rho);
  // The gain first: what a slow branch would take in the end may be more than a cell has.
  const std::int32_t made = wide_drop(scaled(scaled(ohm, b.law.itself, kUnitBits), gain, kLongGainBits), ma);
  const std::int32_t kept = scaled(v >> (kUnitBits - kVoltageBits), kOne - gain, kLongGainBits);
  // A branch that is far from its end gets there sooner when its time falls with its resistance: g falls with tau by
  // x exp(-x) / (1 - exp(-x)) of the share, about (1 - g) (1 + g / 2).
  const std::int32_t on_its_way = scaled(kOne - gain, kOne + gain / 2, kLongGainBits);
  return {kept, made, scaled(kept + made, gain, kLongGainBits),
          b.ohm_change - scaled(b.time_change, on_its_way, kLongGainBits),
          scaled(scaled(ohm, b.law.growth, kUnitBits), gain, kLongGainBits)};
}

/// What a rise [0.1 K 2^-5] makes of a part [2^-28 of it].
std::int32_t fine_change(std::int32_t by_count, std::int32_t rise) {
  return scaled(by_count, rise, kLawBits - kUnitBits + kFineBits);
}

/// By how much the temperature has risen at the end, as far as the resistances follow it [0.1 K 2^-5]. What warms falls
/// with the resistance on the way.
std::int32_t warmed(const HorizonCell& cell, std::int32_t quarter_drops, std::int32_t ma) {
  const HorizonHeat& heat = cell.horizon.heat;
  const std::int32_t power = scaled(quarter_drops, ma, kVoltageBits - 2);  // mA q
  const std::int64_t all = (std::int64_t{magnitude(power)} * heat.rise) >> (kRiseBits - kFineBits);
  const auto cold = static_cast<std::int32_t>(min(all, std::int64_t{kRiseMost}));
  const std::int32_t rise = cold + scaled(fine_change(heat.change.r0, cold / 2), cold, kUnitBits);
  constexpr std::int32_t kFine = 1 << kFineBits;
  const std::int32_t low = heat.low * kFine, high = heat.high * kFine, now = cell.warmer * kFine;
  return within(now + rise, low, high) - within(now, low, high);
}

/// A drop with what the heat has made of it: nothing at least, half as much again at most, so that it fits.
std::int32_t heated(std::int32_t drop, std::int32_t by_count, std::int32_t rise) {
  return drop + scaled(drop, within(fine_change(by_count, rise), -kUnit, kUnit / 2), kUnitBits);
}

/// Above the bound is positive.
std::int64_t margin_of(const HorizonBound& bound, const CellEnd& end) {
  const std::int64_t above = std::int64_t{end.voltage} - filter_voltage(bound.voltage);
  return bound.direction == Direction::kDischarge ? above : -above;
}

/// By how much the current may still grow, a line through here [mA].
std::int32_t newton_step(std::int64_t margin, std::int32_t fall) {
  const std::int32_t top = held(margin, -kMarginMost, kMarginMost) * 8;  // 2^-29
  const std::int32_t bottom = fall >> (kFallBits - 29);
  return top / max(bottom, std::int32_t{1});
}

/// What the charge allows: not below empty, not above full.
std::int32_t most_by_charge(const HorizonCell& cell, const HorizonBound& bound) {
  const std::int32_t s = cell.filter.s, share = cell.horizon.share;
  if (!bound.by_charge) return bound.most_ma;
  const std::int64_t left = max(bound.direction == Direction::kDischarge ? s : kUnit - s, std::int32_t{0});
  const std::int64_t own = std::int64_t{share} + scaled(share, cell.fade, kUnitBits);
  if (own * bound.most_ma <= left << kShareBits) return bound.most_ma;  // and no division
  return static_cast<std::int32_t>((left << kShareBits) / own);
}

/// Of 32 bits, rounded down, digit by digit.
std::int32_t square_root(std::int32_t x) {
  std::int32_t root = 0, rest = x;
  for (std::int32_t bit = 1 << 30; bit > 0; bit >>= 2) {
    const bool fits = rest >= root + bit;
    if (fits) rest -= root + bit;
    root = fits ? (root >> 1) + bit : root >> 1;
  }
  return root;
}

}  // namespace

std::int32_t prudent_fade(const CellFilter& filter) {
  const std::int64_t deviation = square_root(filter.p.ff);
  return held(filter.fade + (deviation << (kUnitBits - kVarianceBits / 2)), kFadeLow, kFadeHigh);
}

PartFactors heat_change(const SocFilter& filter) {
  const auto share = [](std::int32_t per_count, std::int32_t factor) {
    return saturated32((std::int64_t{per_count} << kUnitBits) / max(factor, kLeastFactor));
  };
  const PartFactors &k = slope_of(filter.model.by_temperature, filter.heat_of.raw()), &now = filter.warm;
  return {share(k.r0, now.r0), share(k.r1, now.r1), share(k.r2, now.r2), share(k.time1, now.time1),
          share(k.time2, now.time2)};
}

Horizon make_horizon(const Config& config, const SocFilter& filter, Duration time, const PartFactors& change) {
  Horizon out;
  out.ms = time.ms();
  // Half milliampere milliseconds: two for each.
  VOLTLAP_REQUIRE(filter.charge_bits > kShareBits);  // a milliampere hour has 22
  out.share = saturated32(shifted(2LL * out.ms * filter.per_charge, filter.charge_bits - kShareBits));
  if (config.heat_capacity_j_per_k == 0 || !filter.heat_known) return out;
  // 10 counts a kelvin, milliamperes, milliseconds, 4 q a volt
  const std::int64_t joules = 4'000'000LL * config.heat_capacity_j_per_k;
  out.heat.rise = saturated32((std::int64_t{10} * out.ms << kRiseBits) / joules);
  const WarmthCurve& curve = filter.model.by_temperature;
  out.heat.low = curve.low() - filter.heat_of.raw();
  out.heat.high = curve.high() - filter.heat_of.raw();
  out.heat.change = change;
  return out;
}

CellEnd cell_end(const HorizonCell& cell, std::int32_t ma) {
  const CellFilter& f = cell.filter;
  const CellModel& m = cell.pack.model;
  const std::int64_t counted = (std::int64_t{cell.horizon.share} * ma) >> kShareBits;
  const std::int32_t drawn = held(counted, -kUnit, kUnit);
  const std::int32_t own = drawn + scaled(drawn, cell.fade, kUnitBits);
  const std::int32_t end = inside_charge(f.s - own), middle = inside_charge(f.s - own / 2);
  std::uint8_t interval = f.interval;
  const OcvNow ocv = ocv_at(m, end, interval);
  const CircuitPoint c = branches_at(m, middle);
  const PartLaw& law = m.by_current;
  const OnLaw at = on_law(law, magnitude(ma));
  const PartFactors &k = law.per_count, &warm = cell.pack.warm, &change = cell.horizon.heat.change;
  const auto by = [&](std::int32_t per_count, std::int32_t factor) { return law_of(per_count, at, factor); };
  const auto time = [&](std::int32_t per_count, std::int32_t factor) {
    return both(factor_of(per_count, at.above), factor);
  };
  const BranchPart one{c.r1, c.rate1, by(k.r1, warm.r1), time(k.time1, warm.time1), change.r1, change.time1};
  const BranchPart two{c.r2, c.rate2, by(k.r2, warm.r2), time(k.time2, warm.time2), change.r2, change.time2};
  const BranchEnd e1 = branch_end(cell, one, f.v1, ma), e2 = branch_end(cell, two, f.v2, ma);
  const Law zero = by(k.r0, warm.r0);
  const std::int32_t ohm0 = own_ohm(series_at(m, end), f.rho);
  const std::int32_t d0 = wide_drop(scaled(ohm0, zero.itself, kUnitBits), ma);
  const std::int32_t rise = warmed(cell, d0 / 4 + e1.warms / 4 + e2.warms / 4, ma);
  const std::int64_t drops = std::int64_t{heated(d0, change.r0, rise)} + heated(e1.made, e1.change, rise / 2) +
                             heated(e2.made, e2.change, rise / 2) + e1.kept + e2.kept -
                             (f.miss >> (kUnitBits - kVoltageBits));
  constexpr int kByCharge = kSlopeBits + kUnitBits + kShareBits - kFallBits;
  const std::int64_t fall = ((std::int64_t{ocv.slope} * cell.horizon.share) >> kByCharge) +
                            scaled(ohm0, zero.growth, kUnitBits) + e1.fall + e2.fall;
  return {saturated32(ocv.voltage - drops), saturated32(fall)};
}

std::int32_t current_until(const HorizonCell& cell, const HorizonBound& bound, std::int32_t last_ma) {
  const std::int32_t sign = bound.direction == Direction::kDischarge ? 1 : -1;
  const std::int32_t most = most_by_charge(cell, bound);
  std::int32_t low = 0, high = most;  // low: within the bound, or nothing
  std::int32_t x = min(last_ma, most);
  for (int look = 0; look < kMostLooks; ++look) {
    const CellEnd end = cell_end(cell, sign * x);
    const std::int64_t margin = margin_of(bound, end);
    if (margin >= 0) {
      if (x == most) return most;
      low = x;
    } else {
      if (x == 0) return 0;
      high = x;
    }
    const std::int32_t step = newton_step(margin, end.fall);
    const std::int64_t next = std::int64_t{x} + step;
    const std::int32_t close = (x >> kCloseBits) + kCloseMa;
    if (magnitude(margin) <= kCloseMargin && magnitude(step) <= close) return held(next, low, high);
    x = look < kNewtonLooks ? held(next, 0, most) : low + (high - low) / 2;
  }
  return low;
}

}  // namespace voltlap::bms
