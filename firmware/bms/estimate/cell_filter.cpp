// SPDX-License-Identifier: Apache-2.0
#include "bms/estimate/cell_filter.hpp"

#include "base/require.hpp"

namespace voltlap::bms {
namespace {

// Growth of the variances in 100 ms [2^-32 of the unit's square]. Chosen on drawn endurances (soc-test).
constexpr std::int32_t kGrowthSoc = 150;    // 3.5e-8: 1 point in 5 min
constexpr std::int32_t kGrowthBranch = 700;
constexpr std::int32_t kGrowthScale = 430;   // 1e-7: 3 % in 15 min
constexpr std::int32_t kGrowthFade = 4;
constexpr std::int32_t kGrowthStep_ms = 100;

// What the circuit leaves of a reading: 30 mV, and a fifth of what R0 takes; at 10 Hz 9 and 60 mV of a second.
constexpr int kInnovationBits = 23;                 // of S, to 256: 64 V, and whatever the variances are S fits
constexpr std::int32_t kReadingVariance = 120'796;  // (30 mV = 0.12 q)^2
constexpr std::int32_t kDropShare = 335'544;        // 0.2^2

// No variance falls below it: a filter that is sure learns nothing more, and rounding (1 in 2^-32) must stay small.
constexpr std::int32_t kLeastVariance = 4'096;      // 1e-6: 0.1 points, 0.25 mV, 0.1 %
constexpr std::int32_t kMostVariance = 429'496'730; // 0.1: 32 points, 80 mV, 32 %
constexpr std::int32_t kDropMost = 4 * kUnit;       // 1 V
constexpr std::int32_t kInnovationMost = kUnit;     // 250 mV in one step

std::int32_t within(std::int64_t x, std::int32_t low, std::int32_t high) {
  return x < low ? low : (x > high ? high : static_cast<std::int32_t>(x));
}


/// 1 - exp(-x), x = dt / tau [2^-28], to x^4; x at most 1, where it is 0.625 (0.632).
std::int32_t gain_of(std::int32_t rate, std::int32_t elapsed_ms) {
  const std::int64_t all = (std::int64_t{rate} * elapsed_ms) >> (kRateBits - kUnitBits);
  const std::int32_t x = all > kUnit ? kUnit : static_cast<std::int32_t>(all);
  const std::int32_t half_square = product(x, x, kUnitBits + 1);
  const std::int32_t rest = kUnit / 3 - x / 12;  // of x^2/2, taken x times
  return x - half_square + product(half_square, product(x, rest, kUnitBits), kUnitBits);
}

/// a b in the variance's unit, of a share.
std::int32_t part(std::int32_t share, std::int32_t variance) { return product(share, variance, kUnitBits); }

std::int32_t grown(std::int64_t variance, std::int64_t growth) {
  return within(variance + growth, kLeastVariance, kMostVariance);
}

std::int64_t growth(std::int32_t in_100_ms, std::int32_t elapsed_ms) {
  return std::int64_t{in_100_ms} * elapsed_ms / kGrowthStep_ms;
}

std::int32_t covariance(std::int64_t x) { return within(x, -kMostVariance, kMostVariance); }

/// A row of F P: what becomes of a covariance with a branch.
std::int32_t moved(std::int32_t g, std::int32_t b, std::int32_t with_branch, std::int32_t with_scale) {
  return covariance(std::int64_t{with_branch} - part(g, with_branch) + part(b, with_scale));
}

struct Branch {
  std::int32_t gain, drive;  ///< g, and F of the branch by rho
};

/// A rate at a time that is `factor` times as long, within 2^-10 at a factor of 2^-4, the least.
std::int32_t slowed(std::int32_t rate, std::int32_t factor) {
  constexpr int kBits = 14;
  constexpr std::int32_t kLeast = 1 << (kBits - 4);
  const std::int32_t coarse = factor >> (kUnitBits - kBits);
  return product(rate, (1 << 30) / (coarse < kLeast ? kLeast : coarse), 30 - kBits);
}

Branch branch_of(const FilterInterval& interval, std::int32_t rate, std::int32_t time_factor, std::int32_t ohm,
                 std::int32_t ohm_factor) {
  const std::int32_t gain = gain_of(slowed(rate, time_factor), interval.elapsed_ms);
  const std::int32_t drop = product(drop_of(ohm, interval.mean_ma), ohm_factor, kUnitBits);
  return {gain, product(gain, drop, kUnitBits)};
}

/// What the count's own error does to the charge: s with all others, then with itself.
void advance_charge(std::int32_t drawn, CellCovariance& p) {
  const std::int32_t with_fade = covariance(std::int64_t{p.sf} - part(drawn, p.ff));
  p.ss = grown(std::int64_t{p.ss} - part(drawn, p.sf) - part(drawn, with_fade), 0);
  p.s1 = covariance(std::int64_t{p.s1} - part(drawn, p.v1f));
  p.s2 = covariance(std::int64_t{p.s2} - part(drawn, p.v2f));
  p.sr = covariance(std::int64_t{p.sr} - part(drawn, p.rf));
  p.sf = with_fade;
}

void advance_branches(const Branch& one, const Branch& two, std::int32_t elapsed_ms, CellCovariance& p) {
  const std::int32_t cross = moved(two.gain, two.drive, p.v12, p.v1r);  // of v1 with v2 as it becomes
  const std::int32_t own1 = moved(one.gain, one.drive, p.v11, p.v1r), own2 = moved(two.gain, two.drive, p.v22, p.v2r);
  p.s1 = moved(one.gain, one.drive, p.s1, p.sr);
  p.s2 = moved(two.gain, two.drive, p.s2, p.sr);
  p.v1f = moved(one.gain, one.drive, p.v1f, p.rf);
  p.v2f = moved(two.gain, two.drive, p.v2f, p.rf);
  p.v1r = moved(one.gain, one.drive, p.v1r, p.rr);
  p.v2r = moved(two.gain, two.drive, p.v2r, p.rr);
  p.v12 = moved(one.gain, one.drive, cross, p.v2r);
  const std::int64_t branch = growth(kGrowthBranch, elapsed_ms);
  p.ss = grown(p.ss, growth(kGrowthSoc, elapsed_ms));
  p.v11 = grown(moved(one.gain, one.drive, own1, p.v1r), branch);
  p.v22 = grown(moved(two.gain, two.drive, own2, p.v2r), branch);
  p.rr = grown(p.rr, growth(kGrowthScale, elapsed_ms));
  p.ff = grown(p.ff, growth(kGrowthFade, elapsed_ms));
}

/// P H' [2^-28], and what becomes of it: gains.
struct Column {
  std::int32_t s, v1, v2, rho, fade;
};

/// H, in 2^-24 but the ones.
struct Sensitivity {
  std::int32_t slope, drop;
};

/// A row of P times H', or that times H: s slope - v1 - v2 - rho drop, with 24 bits more.
std::int64_t seen(const Sensitivity& h, std::int32_t s, std::int32_t v1, std::int32_t v2, std::int32_t rho) {
  return std::int64_t{s} * h.slope - ((std::int64_t{v1} + v2) * (1 << kSlopeBits)) - std::int64_t{rho} * h.drop;
}

Column column_of(const CellCovariance& p, const Sensitivity& h) {
  const auto row = [&](std::int32_t s, std::int32_t v1, std::int32_t v2, std::int32_t rho) {
    return saturated32(shifted(seen(h, s, v1, v2, rho), kVarianceBits + kSlopeBits - kUnitBits));
  };
  return {row(p.ss, p.s1, p.s2, p.sr), row(p.s1, p.v11, p.v12, p.v1r), row(p.s2, p.v12, p.v22, p.v2r),
          row(p.sr, p.v1r, p.v2r, p.rr), row(p.sf, p.v1f, p.v2f, p.rf)};
}

/// H P H' + r [2^-23].
std::int32_t innovation_variance(const Column& c, const Sensitivity& h) {
  const std::int64_t hph = shifted(seen(h, c.s, c.v1, c.v2, c.rho), kUnitBits + kSlopeBits - kInnovationBits);
  const std::int32_t square = product(h.drop, h.drop, 2 * kSlopeBits - kInnovationBits);
  const std::int32_t r = kReadingVariance + product(square, kDropShare, kInnovationBits);
  return within(r + (hph > 0 ? hph : 0), r, std::numeric_limits<std::int32_t>::max());
}

/// 1 / S = mantissa 2^(zeros - 47): a division of 32 bits, right within 2^-15.
struct Inverse {
  std::int32_t mantissa;  ///< 2^15 .. 2^16
  int zeros;
};
static_assert(kReadingVariance > 1 << 16, "less than 15 zeros");

Inverse inverse_of(std::int32_t s) {
  VOLTLAP_REQUIRE(s > 0);
  const int zeros = __builtin_clz(static_cast<std::uint32_t>(s));
  const std::uint32_t top = static_cast<std::uint32_t>(s) << zeros;  // 2^31 .. 2^32
  return {static_cast<std::int32_t>(0xFFFF'FFFFU / (top >> 15)), zeros};
}

/// c / S [2^-28].
std::int32_t over(std::int32_t c, const Inverse& inverse) {
  return product(c, inverse.mantissa, 47 - kInnovationBits - inverse.zeros);
}

/// Of either sign alike.
std::int32_t size_of(std::int32_t ma) { return ma < 0 ? -ma : ma; }

/// R0 I, within a volt.
std::int32_t series_drop(const CellModel& model, const PartFactors& warm, std::int32_t ma, std::int32_t s) {
  const PartLaw& law = model.by_current;
  const std::int32_t factor = product(factor_of(law, law.per_count.r0, size_of(ma)), warm.r0, kUnitBits);
  return within(product(drop_of(circuit_at(model, s).r0, ma), factor, kUnitBits), -kDropMost, kDropMost);
}

void correct(const Column& c, const Column& k, std::int32_t y, CellFilter& f) {
  f.s = within(std::int64_t{f.s} + product(k.s, y, kUnitBits), kSocLow, kSocHigh);
  f.v1 = within(std::int64_t{f.v1} + product(k.v1, y, kUnitBits), -kBranchMost, kBranchMost);
  f.v2 = within(std::int64_t{f.v2} + product(k.v2, y, kUnitBits), -kBranchMost, kBranchMost);
  f.rho = within(std::int64_t{f.rho} + product(k.rho, y, kUnitBits), kScaleLow, kScaleHigh);
  f.fade = within(std::int64_t{f.fade} + product(k.fade, y, kUnitBits), kFadeLow, kFadeHigh);
  constexpr int kBits = 2 * kUnitBits - kVarianceBits;
  CellCovariance& p = f.p;
  p.ss = grown(std::int64_t{p.ss} - product(k.s, c.s, kBits), 0);
  p.s1 = covariance(std::int64_t{p.s1} - product(k.s, c.v1, kBits));
  p.s2 = covariance(std::int64_t{p.s2} - product(k.s, c.v2, kBits));
  p.sr = covariance(std::int64_t{p.sr} - product(k.s, c.rho, kBits));
  p.v11 = grown(std::int64_t{p.v11} - product(k.v1, c.v1, kBits), 0);
  p.v12 = covariance(std::int64_t{p.v12} - product(k.v1, c.v2, kBits));
  p.v1r = covariance(std::int64_t{p.v1r} - product(k.v1, c.rho, kBits));
  p.v22 = grown(std::int64_t{p.v22} - product(k.v2, c.v2, kBits), 0);
  p.v2r = covariance(std::int64_t{p.v2r} - product(k.v2, c.rho, kBits));
  p.rr = grown(std::int64_t{p.rr} - product(k.rho, c.rho, kBits), 0);
  p.sf = covariance(std::int64_t{p.sf} - product(k.s, c.fade, kBits));
  p.v1f = covariance(std::int64_t{p.v1f} - product(k.v1, c.fade, kBits));
  p.v2f = covariance(std::int64_t{p.v2f} - product(k.v2, c.fade, kBits));
  p.rf = covariance(std::int64_t{p.rf} - product(k.rho, c.fade, kBits));
  p.ff = grown(std::int64_t{p.ff} - product(k.fade, c.fade, kBits), 0);
}

}  // namespace

void begin_filter(const CellDoubt& doubt, CellFilter& filter) {
  filter.p = CellCovariance{};
  filter.p.ss = grown(doubt.s, 0);
  filter.p.v11 = grown(doubt.v1, 0);
  filter.p.v22 = grown(doubt.v2, 0);
  filter.p.rr = grown(doubt.rho, 0);
  filter.p.ff = grown(doubt.fade, 0);
}

void predict_cell(const CellModel& model, const PartFactors& warm, const FilterInterval& interval, CellFilter& f) {
  VOLTLAP_REQUIRE(interval.elapsed_ms > 0 && interval.elapsed_ms <= 2'000);
  const CircuitPoint circuit = circuit_at(model, f.s);
  const PartFactors loaded = factors_of(model.by_current, size_of(interval.mean_ma));
  const Branch one = branch_of(interval, circuit.rate1, product(loaded.time1, warm.time1, kUnitBits), circuit.r1,
                               product(loaded.r1, warm.r1, kUnitBits));
  const Branch two = branch_of(interval, circuit.rate2, product(loaded.time2, warm.time2, kUnitBits), circuit.r2,
                               product(loaded.r2, warm.r2, kUnitBits));
  const auto advanced = [&](const Branch& b, std::int32_t v) {
    return within(std::int64_t{v} - product(b.gain, v, kUnitBits) + product(b.drive, f.rho, kUnitBits), -kBranchMost,
                  kBranchMost);
  };
  const std::int64_t drawn = std::int64_t{interval.drawn} + product(interval.drawn, f.fade, kUnitBits);
  f.s = within(f.s - drawn, kSocLow, kSocHigh);
  f.v1 = advanced(one, f.v1);
  f.v2 = advanced(two, f.v2);
  advance_charge(interval.drawn, f.p);
  advance_branches(one, two, interval.elapsed_ms, f.p);
}

void update_cell(const CellModel& model, const PartFactors& warm, const FilterReading& reading, CellFilter& f) {
  const OcvNow ocv = ocv_at(model, f.s, f.interval);
  const std::int32_t drop = series_drop(model, warm, reading.current_ma, f.s);
  const std::int64_t apart = std::int64_t{filter_voltage(reading.voltage)} - ocv.voltage;
  const std::int64_t y = apart * (1 << (kUnitBits - kVoltageBits)) + f.v1 + f.v2 + product(f.rho, drop, kUnitBits);
  const Sensitivity h{ocv.slope, drop >> (kUnitBits - kSlopeBits)};
  const Column c = column_of(f.p, h);
  const Inverse inverse = inverse_of(innovation_variance(c, h));
  const Column k{over(c.s, inverse), over(c.v1, inverse), over(c.v2, inverse), over(c.rho, inverse),
                 over(c.fade, inverse)};
  correct(c, k, within(y, -kInnovationMost, kInnovationMost), f);
}

}  // namespace voltlap::bms
