// SPDX-License-Identifier: Apache-2.0
#include "bms/estimate/cell_model.hpp"

#include "base/interpolate.hpp"
#include "base/require.hpp"

namespace voltlap::bms {
namespace {

/// 400 dV / ds: 0.1 mV a ppm are 100 V over the whole charge, 400 q.
std::int32_t slope_of(const OcvTable& table, std::size_t i) {
  const std::int64_t rise = std::int64_t{table.voltage[i + 1].raw()} - table.voltage[i].raw();
  const std::int64_t run = std::int64_t{table.soc[i + 1].raw()} - table.soc[i].raw();
  VOLTLAP_REQUIRE(rise > 0 && run > 0);
  const std::int64_t slope = divide_rounded((rise * 400) << kSlopeBits, run);
  return slope > kSlopeMax ? kSlopeMax : static_cast<std::int32_t>(slope);
}

void fill_ocv(const OcvTable& table, CellModel& model) {
  VOLTLAP_REQUIRE(table.count >= 2 && table.count <= kMaxTablePoints);
  model.intervals = static_cast<std::uint8_t>(table.count - 1);
  for (std::size_t i = 0; i < table.count; ++i) {
    model.ocv_soc[i] = filter_soc(table.soc[i]);
    model.ocv[i] = filter_voltage(table.voltage[i]);
  }
  for (std::size_t i = 0; i < model.intervals; ++i) model.ocv_slope[i] = slope_of(table, i);
}

/// uOhm mA are nV, and 2^30 q a volt.
std::int32_t ohm(Resistance r) {
  constexpr std::int64_t kPerNanovolt = 1'152'921'505;  // 2^30 / 1e9 in 2^-30
  return saturated32(shifted(kPerNanovolt * r.raw(), 30 - kOhmBits));
}

std::int32_t rate(Duration time) {
  VOLTLAP_REQUIRE(time > Duration{});
  return saturated32((std::int64_t{1} << kRateBits) / time.ms());
}

constexpr int kAlongBits = 19;  // of the way between two temperatures, 400 K at most

constexpr std::size_t kPointsInTurn = 11;  // chosen: the model is whole after three steps
static_assert((kCircuitSteps + 1) % kPointsInTurn == 0, "no turn goes beyond the last point");

void grow_circuit(const Config& config, CellModel& model) {
  const ResistanceTable& at = config.resistance;
  const BranchTable& table = config.branches;
  const auto read = [&](const Resistance* values, Soc soc) { return ohm(interpolate(at.soc, values, at.count, soc)); };
  // Rates, and not times, are straight between the points: a filter has no division to spare.
  Quantity<struct RateTag> rate1[kMaxTablePoints], rate2[kMaxTablePoints];
  for (std::size_t i = 0; i < at.count; ++i) {
    rate1[i] = Quantity<RateTag>::from_raw(rate(table.time1[i]));
    rate2[i] = Quantity<RateTag>::from_raw(rate(table.time2[i]));
  }
  const std::size_t end = model.points + kPointsInTurn;
  for (std::size_t k = model.points; k < end; ++k) {
    const Soc soc = Soc::from_raw(static_cast<std::int32_t>(k * 1'000'000 / kCircuitSteps));
    model.circuit[k] = {read(table.series, soc), read(table.branch1, soc), read(table.branch2, soc),
                        interpolate(at.soc, rate1, at.count, soc).raw(),
                        interpolate(at.soc, rate2, at.count, soc).raw()};
    model.points = static_cast<std::uint8_t>(k + 1);
  }
}

/// `per_unit`: counts that the slope's unit has.
PartFactors slopes_of(const PartSlopes& from, std::int32_t per_unit) {
  const auto slope = [per_unit](std::int32_t ppm) {
    return static_cast<std::int32_t>((std::int64_t{ppm} * (std::int64_t{1} << kLawBits)) / (1'000'000LL * per_unit));
  };
  return {slope(from.series), slope(from.branch1), slope(from.branch2), slope(from.time1), slope(from.time2)};
}

PartFactors factors_of(const PartShares& from) {
  const auto factor = [](std::int32_t ppm) {
    return static_cast<std::int32_t>((std::int64_t{ppm} << kUnitBits) / 1'000'000);
  };
  return {factor(from.series), factor(from.branch1), factor(from.branch2), factor(from.time1), factor(from.time2)};
}

PartFactors slope_between(const PartFactors& a, const PartFactors& b, std::int32_t counts) {
  const auto slope = [counts](std::int32_t from, std::int32_t to) {
    return saturated32((std::int64_t{to} - from) * (1 << (kLawBits - kUnitBits)) / counts);
  };
  return {slope(a.r0, b.r0), slope(a.r1, b.r1), slope(a.r2, b.r2), slope(a.time1, b.time1), slope(a.time2, b.time2)};
}

void fill_warmth(const BranchTable& from, WarmthCurve& curve) {
  curve.points = from.warmth_count;
  for (std::size_t i = 0; i < curve.points; ++i) {
    curve.at[i] = from.warmth_at[i].raw();
    curve.factor[i] = factors_of(from.warmth[i]);
    curve.slope[i] = {0, 0, 0, 0, 0};
    if (i > 0) {
      curve.slope[i - 1] = slope_between(curve.factor[i - 1], curve.factor[i], curve.at[i] - curve.at[i - 1]);
    }
  }
}

void fill_laws(const Config& config, CellModel& model) {
  constexpr std::int32_t kPerAmpere = 1'000;
  const BranchTable& from = config.branches;
  model.by_current = {from.current_min.raw(), from.current_max.raw(), from.current_reference.raw(),
                      slopes_of(from.per_ampere, kPerAmpere)};
  fill_warmth(from, model.by_temperature);
}

/// Among the points of the circuit.
struct Place {
  std::size_t step;
  std::int32_t along;  ///< [2^-31] of the way to the next one
};

Place place_of(std::int32_t soc) {
  const std::int32_t inside = soc < 0 ? 0 : (soc >= kUnit ? kUnit - 1 : soc);
  const std::int32_t along = inside & ((1 << kCircuitStepBits) - 1);
  return {static_cast<std::size_t>(inside >> kCircuitStepBits), along << (31 - kCircuitStepBits)};
}

/// Two neighbours of one sign: their difference fits.
std::int32_t between(std::int32_t low, std::int32_t high, std::int32_t along) {
  return low + static_cast<std::int32_t>((std::int64_t{high - low} * along) >> 31);
}

}  // namespace

bool grow_model(const Config& config, CellModel& model) {
  if (model.points > kCircuitSteps) return true;
  if (model.points == 0) fill_ocv(config.ocv, model);
  if (model.points == kPointsInTurn) fill_laws(config, model);
  grow_circuit(config, model);
  return model.points > kCircuitSteps;
}

void make_model(const Config& config, CellModel& model) {
  model.points = 0;
  while (!grow_model(config, model)) {
  }
}

PartFactors factors_of(const PartLaw& law, std::int32_t counts) {
  const PartFactors& k = law.per_count;
  const std::int32_t above = above_reference(law, counts);
  return {factor_of(k.r0, above), factor_of(k.r1, above), factor_of(k.r2, above), factor_of(k.time1, above),
          factor_of(k.time2, above)};
}

namespace {

std::size_t interval_of(const WarmthCurve& curve, std::int32_t counts) {
  std::size_t i = 0;
  while (i + 1 < curve.points && counts >= curve.at[i + 1]) ++i;
  return i;
}

}  // namespace

PartFactors factors_of(const WarmthCurve& curve, std::int32_t counts) {
  const std::int32_t inside = counts < curve.low() ? curve.low() : counts;
  const std::size_t i = interval_of(curve, inside);
  if (i + 1 == curve.points) return curve.factor[i];
  const PartFactors &a = curve.factor[i], &b = curve.factor[i + 1];
  const std::int32_t along = ((inside - curve.at[i]) << kAlongBits) / (curve.at[i + 1] - curve.at[i]);
  const auto between = [along](std::int32_t from, std::int32_t to) {
    return from + static_cast<std::int32_t>((std::int64_t{to} - from) * along >> kAlongBits);
  };
  return {between(a.r0, b.r0), between(a.r1, b.r1), between(a.r2, b.r2), between(a.time1, b.time1),
          between(a.time2, b.time2)};
}

const PartFactors& slope_of(const WarmthCurve& curve, std::int32_t counts) {
  return curve.slope[interval_of(curve, counts)];
}

OcvNow ocv_at(const CellModel& model, std::int32_t soc, std::uint8_t& interval) {
  std::size_t i = interval;
  VOLTLAP_REQUIRE(i < model.intervals);
  while (i > 0 && soc < model.ocv_soc[i]) --i;
  while (i + 1 < model.intervals && soc >= model.ocv_soc[i + 1]) ++i;
  interval = static_cast<std::uint8_t>(i);
  const std::int32_t along = scaled(model.ocv_slope[i], soc - model.ocv_soc[i], kSlopeBits + kUnitBits - kVoltageBits);
  return {model.ocv[i] + along, model.ocv_slope[i]};
}

CircuitPoint branches_at(const CellModel& model, std::int32_t soc) {
  const Place at = place_of(soc);
  const CircuitPoint& a = model.circuit[at.step];
  const CircuitPoint& b = model.circuit[at.step + 1];
  return {0, between(a.r1, b.r1, at.along), between(a.r2, b.r2, at.along), between(a.rate1, b.rate1, at.along),
          between(a.rate2, b.rate2, at.along)};
}

std::int32_t series_at(const CellModel& model, std::int32_t soc) {
  const Place at = place_of(soc);
  return between(model.circuit[at.step].r0, model.circuit[at.step + 1].r0, at.along);
}

}  // namespace voltlap::bms
