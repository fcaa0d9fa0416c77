// SPDX-License-Identifier: Apache-2.0
#include "apps/limit_bisection.hpp"

#include <algorithm>
#include <cmath>

namespace voltlap::plant {
namespace {

constexpr double kMsPerHour = 3.6e6;
constexpr double kVoltsPerUnit = 0.25;

double unit(std::int32_t raw) { return std::ldexp(raw, -bms::kUnitBits); }

struct Circuit {
  double r0, r1, r2, rate1, rate2;  // of q / mA, 1 / ms
};

Circuit circuit_at(const bms::CellModel& model, double soc) {
  const double at = std::clamp(soc, 0.0, 1.0) * bms::kCircuitSteps;
  const auto k = std::min(static_cast<std::size_t>(at), bms::kCircuitSteps - 1);
  const double along = at - static_cast<double>(k);
  const bms::CircuitPoint &a = model.circuit[k], &b = model.circuit[k + 1];
  const auto read = [along](std::int32_t low, std::int32_t high, int bits) {
    return std::ldexp(low + (static_cast<double>(high) - low) * along, -bits);
  };
  constexpr int kOhm = bms::kUnitBits + bms::kOhmBits;
  return {read(a.r0, b.r0, kOhm), read(a.r1, b.r1, kOhm), read(a.r2, b.r2, kOhm),
          read(a.rate1, b.rate1, bms::kRateBits), read(a.rate2, b.rate2, bms::kRateBits)};
}

double open_circuit(const bms::CellModel& model, double soc) {
  std::size_t i = 0;
  while (i + 1 < model.intervals && soc >= unit(model.ocv_soc[i + 1])) ++i;
  const double slope = std::ldexp(model.ocv_slope[i], -bms::kSlopeBits);
  return std::ldexp(model.ocv[i], -bms::kVoltageBits) + slope * (soc - unit(model.ocv_soc[i]));
}

}  // namespace

LimitBisection::LimitBisection(const bms::Config& config, const bms::SocFilter& filter, std::size_t cell,
                               Duration horizon, std::int32_t warmer)
    : model_(filter.model),
      warm_(filter.warm),
      filter_(filter.cell[cell].filter),
      share_(horizon.ms() / (config.capacity_mah * kMsPerHour)),
      ms_(horizon.ms()),
      rise_(config.heat_capacity_j_per_k > 0 && filter.heat_known ? 1e-3 * ms_ / config.heat_capacity_j_per_k : 0.0),
      heat_of_(filter.heat_of.raw()),
      temperature_c_(0.1 * (filter.heat_of.raw() + warmer)) {}

double LimitBisection::fade() const {
  const double deviation = std::sqrt(std::ldexp(std::max(filter_.p.ff, 0), -bms::kVarianceBits));
  return std::clamp(unit(filter_.fade) + deviation, -0.25, 0.5);
}

double LimitBisection::end_v(double ma) const {
  const double s = unit(filter_.s), drawn = (1.0 + fade()) * share_ * ma, rho = unit(filter_.rho);
  const double end = std::clamp(s - drawn, -0.05, 1.05), middle = std::clamp(s - 0.5 * drawn, -0.05, 1.05);
  const bms::PartLaw& law = model_.by_current;
  const double above = std::clamp(std::abs(ma), 1.0 * law.low, 1.0 * law.high) - law.reference;
  const auto factor = [&](std::int32_t per_count, std::int32_t warm) {
    return (1.0 + std::ldexp(per_count, -bms::kLawBits) * above) * unit(warm);
  };
  const Circuit c = circuit_at(model_, middle);
  struct Branch {
    double kept, driven, warms, on_its_way;
  };
  const auto branch = [&](double ohm, double rate, double time_factor, double v) {
    const double gain = ms_ == 0.0 ? 1.0 : -std::expm1(-ms_ * rate / std::max(time_factor, 0.26));
    const double kept = v - gain * v, driven = gain * rho * ohm * ma;
    return Branch{kept, driven, gain * (kept + driven), (1.0 - gain) * (1.0 + 0.5 * gain)};
  };
  const Branch one = branch(c.r1 * factor(law.per_count.r1, warm_.r1), c.rate1,
                            factor(law.per_count.time1, warm_.time1), unit(filter_.v1));
  const Branch two = branch(c.r2 * factor(law.per_count.r2, warm_.r2), c.rate2,
                            factor(law.per_count.time2, warm_.time2), unit(filter_.v2));
  const double d0 = rho * circuit_at(model_, end).r0 * factor(law.per_count.r0, warm_.r0) * ma;
  const double warms = d0 + one.warms + two.warms;
  const bms::WarmthCurve& curve = model_.by_temperature;
  const bms::PartFactors& heat = slope_of(curve, heat_of_);
  const double low_c = 0.1 * curve.low(), high_c = 0.1 * curve.high();
  const auto by_count = [](std::int32_t per_count, std::int32_t warm) {
    return std::ldexp(per_count, -bms::kLawBits) / std::max(unit(warm), 0.1);
  };
  const double change0 = by_count(heat.r0, warm_.r0);
  const double cold_k = std::min(100.0, rise_ * std::abs(1e-3 * ma * kVoltsPerUnit * warms));
  const double end_c = temperature_c_ + cold_k * (1.0 + change0 * 5.0 * cold_k);
  const double counts = 10.0 * (std::clamp(end_c, low_c, high_c) - std::clamp(temperature_c_, low_c, high_c));
  const double change1 = by_count(heat.r1, warm_.r1) -
                         one.on_its_way * by_count(heat.time1, warm_.time1);
  const double change2 = by_count(heat.r2, warm_.r2) -
                         two.on_its_way * by_count(heat.time2, warm_.time2);
  const double all = d0 * (1.0 + counts * change0) + one.kept + one.driven * (1.0 + 0.5 * counts * change1) + two.kept +
                     two.driven * (1.0 + 0.5 * counts * change2);
  return kVoltsPerUnit * (open_circuit(model_, end) - all + unit(filter_.miss));
}

double LimitBisection::current_ma(const bms::HorizonBound& bound) const {
  const bool discharge = bound.direction == bms::Direction::kDischarge;
  const double bound_v = 1e-4 * bound.voltage.raw(), sign = discharge ? 1.0 : -1.0;
  const auto inside = [&](double ma) {
    const double soc = unit(filter_.s) - sign * (1.0 + fade()) * share_ * ma;
    const bool charge = share_ == 0.0 || (discharge ? soc >= 0.0 : soc <= 1.0);
    return charge && sign * (end_v(sign * ma) - bound_v) >= 0.0;
  };
  double low = 0.0, high = bound.most_ma;
  if (inside(high)) return high;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (inside(middle) ? low : high) = middle;
  }
  return low;
}

}  // namespace voltlap::plant
