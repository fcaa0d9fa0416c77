// SPDX-License-Identifier: Apache-2.0
#include "bms/estimate/cell_filter.hpp"

#include "base/require.hpp"
#include "bms/estimate/branch_gain.hpp"

namespace voltlap::bms {
namespace {

// Growth of the variances in 100 ms [2^-32 of the unit's square]; that of the charge, which is only uncertain while it
// moves, by what is drawn: 1 point over all of it. More of it hides the capacity from the filter for half of a drive.
// Both chosen on drawn endurances with a weak cell, states of limit-test with seed 12 and the Leaf's recordings.
constexpr int kGrowthDrawnBits = 13;         // 2^-13 of what is drawn
constexpr std::int32_t kGrowthBranch = 200;  // 4.7e-8: 1.3 mV in 1 min, but that it decays
constexpr std::int32_t kGrowthScale = 430;   // 1e-7: 3 % in 15 min
constexpr std::int32_t kGrowthFade = 4;      // 1e-9: 1 % in 3 h
constexpr std::int32_t kGrowthStep_ms = 100;

// What the circuit leaves of a reading: 30 mV, and a fifth of what R0 takes; at 10 Hz 9 and 60 mV of a second.
constexpr int kInnovationBits = 23;                 // of S, to 256: 64 V, and whatever the variances are S fits
constexpr std::int32_t kReadingVariance = 120'796;  // (30 mV = 0.12 q)^2
constexpr std::int32_t kDropShare = 10'486;         // 0.2^2 in 2^-18

// No variance falls below it: a filter that is sure learns nothing more, and rounding (1 in 2^-32) must stay small.
constexpr std::int32_t kLeastVariance = 4'096;       // 1e-6: 0.1 points, 0.25 mV, 0.1 %
constexpr std::int32_t kMostVariance = 429'496'730;  // 0.1: 32 points, 80 mV, 32 %
constexpr std::int32_t kDropMost = 4 * kUnit;        // 1 V
constexpr std::int32_t kInnovationMost = kUnit;      // 250 mV in one step

// What CellFilter::miss and ::apart are means of; the second, and what it is worth in r, chosen on the recordings of
// docs/soc_test.md and held against limit-test: a circuit that is right leaves 6 mV for as long, and would be learned
// the slower for it.
constexpr std::int32_t kMissReadings = 8, kApartReadings = 128;
constexpr std::int32_t kApartUsual = 6'442'451;  // 6 mV = 0.024 q
constexpr int kApartBits = 7;                    // 128 of the square of what is beyond

// BMS-082
// A record that the first reading contradicts by two standard deviations: its charge may be a quarter off.
constexpr std::int32_t kContradicted = 268'435'456;  // 0.25^2
constexpr int kTwoDeviationsBits = 35;               // y^2 [2^-56] > 4 S [2^-23]

constexpr int kGainBits = 30;                        // |K| is below sqrt(P / r) / 2 = 1.32

std::int32_t within(std::int32_t x, std::int32_t low, std::int32_t high) {
  return x < low ? low : (x > high ? high : x);
}
std::int32_t within64(std::int64_t x, std::int32_t low, std::int32_t high) {
  return x < low ? low : (x > high ? high : static_cast<std::int32_t>(x));
}

/// Of either sign alike.
constexpr std::int32_t size_of(std::int32_t x) { return x < 0 ? -x : x; }

/// Raised, never cut: a variance that is cut leaves covariances that are too large for it.
std::int32_t raised(std::int32_t variance) { return variance < kLeastVariance ? kLeastVariance : variance; }

std::int32_t begun(std::int32_t variance) { return within(variance, kLeastVariance, kMostVariance); }

std::int32_t grown(std::int32_t variance, std::int32_t in_100_ms, std::int32_t elapsed_ms) {
  constexpr std::int32_t kPerStep = 65'536 / kGrowthStep_ms;
  return variance < kMostVariance ? variance + (in_100_ms * (elapsed_ms * kPerStep) >> 16) : variance;
}

/// A branch over an interval: dv = gain (rho drop - v); F of v by rho is gain drop.
struct Branch {
  std::int32_t gain;   ///< [2^-32]
  std::int32_t drop;   ///< [2^-28]
  std::int32_t drive;  ///< gain drop [2^-32], a drop of more than 250 mV counts as that
};

struct Part {
  std::int32_t ohm, rate;  ///< of the table
  std::int32_t ohm_factor, time_factor;
};

Branch branch_of(const FilterInterval& interval, const Part& part) {
  const std::int32_t gain = gain_of(slowed(part.rate, part.time_factor), interval.elapsed_ms);
  const std::int32_t drop = drop_of(scaled(part.ohm, part.ohm_factor, kUnitBits), interval.mean_ma);
  return {gain, drop, scaled(gain, within(drop, -kUnit, kUnit), kUnitBits)};
}

/// Between two numbers within 2 V, whatever the share.
std::int32_t advanced(const Branch& b, std::int32_t rho, std::int32_t v) {
  const std::int32_t sum = v - part(b.gain, v) + part(b.gain, product(rho, b.drop, kUnitBits));
  return within(sum, -kBranchMost, kBranchMost);
}

/// A row of F P: what becomes of a covariance with a branch.
std::int32_t moved(const Branch& b, std::int32_t with_branch, std::int32_t with_scale) {
  return with_branch - part(b.gain, with_branch) + part(b.drive, with_scale);
}

/// What the count's own error does to the charge: s with all others, then with itself.
void advance_charge(std::int32_t drawn, CellCovariance& p) {
  const std::int32_t with_fade = p.sf - part(drawn, p.ff);
  p.ss = raised(p.ss - part(drawn, p.sf) - part(drawn, with_fade));
  if (p.ss < kMostVariance) p.ss += size_of(drawn) >> kGrowthDrawnBits;
  p.s1 -= part(drawn, p.v1f);
  p.s2 -= part(drawn, p.v2f);
  p.sr -= part(drawn, p.rf);
  p.sf = with_fade;
}

void advance_branches(const Branch& one, const Branch& two, std::int32_t elapsed_ms, CellCovariance& p) {
  const std::int32_t cross = moved(two, p.v12, p.v1r);  // of v1 with v2 as it becomes
  const std::int32_t own1 = moved(one, p.v11, p.v1r), own2 = moved(two, p.v22, p.v2r);
  p.s1 = moved(one, p.s1, p.sr);
  p.s2 = moved(two, p.s2, p.sr);
  p.v1f = moved(one, p.v1f, p.rf);
  p.v2f = moved(two, p.v2f, p.rf);
  p.v1r = moved(one, p.v1r, p.rr);
  p.v2r = moved(two, p.v2r, p.rr);
  p.v12 = moved(one, cross, p.v2r);
  p.v11 = grown(raised(moved(one, own1, p.v1r)), kGrowthBranch, elapsed_ms);
  p.v22 = grown(raised(moved(two, own2, p.v2r)), kGrowthBranch, elapsed_ms);
  p.rr = grown(p.rr, kGrowthScale, elapsed_ms);
  p.ff = grown(p.ff, kGrowthFade, elapsed_ms);
}

/// P H' [2^-28], and what becomes of it: gains [2^-30].
struct Column {
  std::int32_t s, v1, v2, rho, fade;
};

/// H, in 2^-26 but the ones.
struct Sensitivity {
  std::int32_t slope, drop;
};

/// A row of P times H', or that times H: s slope - v1 - v2 - rho drop, with 26 bits more.
std::int64_t seen(const Sensitivity& h, std::int32_t s, std::int32_t v1, std::int32_t v2, std::int32_t rho) {
  return std::int64_t{s} * h.slope - std::int64_t{v1 + v2} * (1 << kSlopeBits) - std::int64_t{rho} * h.drop;
}

Column column_of(const CellCovariance& p, const Sensitivity& h) {
  const auto row = [&](std::int32_t s, std::int32_t v1, std::int32_t v2, std::int32_t rho) {
    return static_cast<std::int32_t>(seen(h, s, v1, v2, rho) >> (kVarianceBits + kSlopeBits - kUnitBits));
  };
  return {row(p.ss, p.s1, p.s2, p.sr), row(p.s1, p.v11, p.v12, p.v1r), row(p.s2, p.v12, p.v22, p.v2r),
          row(p.sr, p.v1r, p.v2r, p.rr), row(p.sf, p.v1f, p.v2f, p.rf)};
}

/// H P H' + r [2^-23].
std::int32_t innovation_variance(const Column& c, const Sensitivity& h, std::int32_t apart) {
  constexpr int kBits = kUnitBits + kSlopeBits - kInnovationBits;
  const auto hph = static_cast<std::int32_t>(seen(h, c.s, c.v1, c.v2, c.rho) >> kBits);
  const std::int32_t square = part(h.drop, h.drop);  // 2^-20
  const std::int32_t size = size_of(apart), beyond = size > kApartUsual ? size - kApartUsual : 0;
  const std::int32_t lasting = scaled(beyond, beyond, 2 * kUnitBits - kInnovationBits - kApartBits);  // to 128
  const std::int32_t r = kReadingVariance + scaled(square, kDropShare, 15) + lasting;
  return r + (hph > 0 ? hph : 0);
}

/// 1 / S [2^-24]: a division of 32 bits, right within 2^-15. S is above 2^-7, so that its inverse fits.
std::int32_t inverse_of(std::int32_t s) {
  static_assert(kReadingVariance > 1 << 16, "less than 15 zeros");
  VOLTLAP_REQUIRE(s > 0);
  const int zeros = __builtin_clz(static_cast<std::uint32_t>(s));
  const std::uint32_t top = static_cast<std::uint32_t>(s) << zeros;  // 2^31 .. 2^32
  return static_cast<std::int32_t>(0xFFFF'FFFFU / (top >> 15) << zeros);
}

/// c / S [2^-30].
std::int32_t over(std::int32_t c, std::int32_t inverse) { return scaled(c, inverse, kUnitBits + 24 - kGainBits); }

/// R0 I, within a volt.
std::int32_t series_drop(const CellModel& model, const PartFactors& warm, std::int32_t ma, std::int32_t s) {
  const PartLaw& law = model.by_current;
  const std::int32_t loaded = factor_of(law.per_count.r0, above_reference(law, size_of(ma)));
  const std::int32_t ohm = scaled(series_at(model, s), scaled(loaded, warm.r0, kUnitBits), kUnitBits);
  return within(drop_of(ohm, ma), -kDropMost, kDropMost);
}

void correct_state(const Column& k, std::int32_t y, CellFilter& f) {
  const std::int32_t fine = y * 4;  // 2^-30
  f.s = within(f.s + part(k.s, fine), kSocLow, kSocHigh);
  f.v1 = within(f.v1 + part(k.v1, fine), -kBranchMost, kBranchMost);
  f.v2 = within(f.v2 + part(k.v2, fine), -kBranchMost, kBranchMost);
  f.rho = within(f.rho + part(k.rho, fine), kScaleLow, kScaleHigh);
  f.fade = within(f.fade + part(k.fade, fine), kFadeLow, kFadeHigh);
}

void correct_covariance(const Column& c, const Column& k, CellCovariance& p) {
  const auto taken = [](std::int32_t gain, std::int32_t of) {
    return scaled(gain, of, kGainBits + kUnitBits - kVarianceBits);
  };
  p.ss = raised(p.ss - taken(k.s, c.s));
  p.s1 -= taken(k.s, c.v1);
  p.s2 -= taken(k.s, c.v2);
  p.sr -= taken(k.s, c.rho);
  p.sf -= taken(k.s, c.fade);
  p.v11 = raised(p.v11 - taken(k.v1, c.v1));
  p.v12 -= taken(k.v1, c.v2);
  p.v1r -= taken(k.v1, c.rho);
  p.v1f -= taken(k.v1, c.fade);
  p.v22 = raised(p.v22 - taken(k.v2, c.v2));
  p.v2r -= taken(k.v2, c.rho);
  p.v2f -= taken(k.v2, c.fade);
  p.rr = raised(p.rr - taken(k.rho, c.rho));
  p.rf -= taken(k.rho, c.fade);
  p.ff = raised(p.ff - taken(k.fade, c.fade));
}

}  // namespace

void begin_filter(const CellDoubt& doubt, CellFilter& filter) {
  filter.p = CellCovariance{};
  filter.p.ss = begun(doubt.s);
  filter.p.v11 = begun(doubt.v1);
  filter.p.v22 = begun(doubt.v2);
  filter.p.rr = begun(doubt.rho);
  filter.p.ff = begun(doubt.fade);
}

void predict_cell(const CellModel& model, const PartFactors& warm, const FilterInterval& interval, CellFilter& f) {
  VOLTLAP_REQUIRE(interval.elapsed_ms > 0 && interval.elapsed_ms <= kElapsedMost_ms);
  const CircuitPoint circuit = branches_at(model, f.s);
  const PartFactors& law = model.by_current.per_count;
  const std::int32_t above = above_reference(model.by_current, size_of(interval.mean_ma));
  const auto factor = [above](std::int32_t per_count, std::int32_t warm_factor) {
    return scaled(factor_of(per_count, above), warm_factor, kUnitBits);
  };
  const Branch one = branch_of(
      interval, {circuit.r1, circuit.rate1, factor(law.r1, warm.r1), factor(law.time1, warm.time1)});
  const Branch two = branch_of(
      interval, {circuit.r2, circuit.rate2, factor(law.r2, warm.r2), factor(law.time2, warm.time2)});
  const std::int32_t share = within64(std::int64_t{interval.drawn} * 16, -kShareMost, kShareMost);
  f.s = within64(std::int64_t{f.s} - interval.drawn - part(share, f.fade), kSocLow, kSocHigh);
  f.v1 = advanced(one, f.rho, f.v1);
  f.v2 = advanced(two, f.rho, f.v2);
  advance_charge(share, f.p);
  advance_branches(one, two, interval.elapsed_ms, f.p);
}

void update_cell(const CellModel& model, const PartFactors& warm, const FilterReading& reading, CellFilter& f) {
  const OcvNow ocv = ocv_at(model, f.s, f.interval);
  const std::int32_t drop = series_drop(model, warm, reading.current_ma, f.s);
  const std::int64_t above_ocv = std::int64_t{filter_voltage(reading.voltage)} - ocv.voltage;
  const std::int64_t y = above_ocv * (1 << (kUnitBits - kVoltageBits)) + f.v1 + f.v2 + product(f.rho, drop, kUnitBits);
  const Sensitivity h{ocv.slope, drop >> (kUnitBits - kSlopeBits)};
  const Column c = column_of(f.p, h);
  const std::int32_t innovation = within64(y, -kInnovationMost, kInnovationMost);
  const std::int32_t variance = innovation_variance(c, h, f.apart);
  if (f.from_record) {
    f.from_record = false;
    if (std::int64_t{innovation} * innovation >> kTwoDeviationsBits > variance) {
      f.p.ss = kContradicted;
      return;
    }
  }
  const std::int32_t inverse = inverse_of(variance);
  const Column k{over(c.s, inverse), over(c.v1, inverse), over(c.v2, inverse), over(c.rho, inverse),
                 over(c.fade, inverse)};
  f.miss += (innovation - f.miss) / kMissReadings;
  f.apart += (innovation - f.apart) / kApartReadings;
  correct_state(k, innovation, f);
  correct_covariance(c, k, f.p);
}

}  // namespace voltlap::bms
