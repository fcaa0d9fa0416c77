// SPDX-License-Identifier: Apache-2.0
// The end of a cell's horizon in double precision: the equations of horizon.hpp with the exponential in the place of
// its series. It shares the curves of a CellModel with the integers, their bounds, and no line of code.
#pragma once
#include <algorithm>
#include <cmath>

#include "bms/limits/horizon.hpp"

namespace voltlap::bms::test {

/// In volts, amperes, seconds and kelvins, but for the model's curves.
class HorizonTwin {
 public:
  const CellModel& model;
  PartFactors warm{};
  double seconds = 1.0, capacity_ah = 10.0, joules_per_k = 0.0;  ///< 0 s: for ever; 0 J/K: no heat
  double temperature = 25.0, warmer = 0.0;
  double soc = 0.5, v1 = 0.0, v2 = 0.0, rho = 1.0, fade = 0.0, miss = 0.0;

  struct End {
    double voltage, ohm, drop;  ///< at the end; what an ampere more takes; of the parts
  };

  [[nodiscard]] End end(double amperes) const {
    const double drawn = std::clamp(amperes * seconds / 3'600.0 / capacity_ah, -1.0, 1.0) * (1.0 + fade);
    const double at_end = std::clamp(soc - drawn, -0.05, 1.05), halfway = std::clamp(soc - 0.5 * drawn, -0.05, 1.05);
    const PartFactors& by = model.by_current.per_count;
    const PartFactors& t = slope_of(model.by_temperature, static_cast<std::int32_t>(std::lround(10.0 * temperature)));
    Part zero = part(at_end, &CircuitPoint::r0, by.r0, warm.r0, amperes);
    zero.drop = std::clamp(zero.drop, -4.0, 4.0);
    const Branch one = branch(v1, part(halfway, &CircuitPoint::r1, by.r1, warm.r1, amperes),
                              rate(halfway, &CircuitPoint::rate1, by.time1, warm.time1, amperes));
    const Branch two = branch(v2, part(halfway, &CircuitPoint::r2, by.r2, warm.r2, amperes),
                              rate(halfway, &CircuitPoint::rate2, by.time2, warm.time2, amperes));
    const double by_k = per_kelvin(t.r0, warm.r0);
    const double rise = risen(amperes * (zero.drop + one.warms() + two.warms()), by_k);
    const double hot1 = one.change(per_kelvin(t.r1, warm.r1), per_kelvin(t.time1, warm.time1));
    const double hot2 = two.change(per_kelvin(t.r2, warm.r2), per_kelvin(t.time2, warm.time2));
    const auto [ocv, slope] = open_circuit(at_end);
    const double drop = heated(zero.drop, by_k * rise) + heated(one.made, hot1 * rise / 2.0) + one.kept +
                        heated(two.made, hot2 * rise / 2.0) + two.kept;
    return {ocv - drop + miss, slope * seconds / 3'600.0 / capacity_ah + zero.more + one.more + two.more, drop};
  }

 private:
  /// Its drop, and what an ampere more adds to it.
  struct Part {
    double drop, more;
  };
  struct Branch {
    double gain, kept, made, more;
    /// What it stores, it does not turn into heat yet.
    [[nodiscard]] double warms() const { return gain * (kept + made); }
    /// By a kelvin: a shorter time takes it further, as long as it is on its way.
    [[nodiscard]] double change(double ohm, double time) const {
      return ohm - time * (1.0 - gain) * (1.0 + gain / 2.0);
    }
  };

  static double unit(std::int32_t raw) { return std::ldexp(raw, -kUnitBits); }
  static double heated(double drop, double change) { return drop * (1.0 + std::clamp(change, -1.0, 0.5)); }

  /// Of a part that is a tenth of its reference by the temperature, no more.
  static double per_kelvin(std::int32_t per_count, std::int32_t now) {
    return 10.0 * std::ldexp(per_count, -kLawBits) / std::max(0.1, unit(now));
  }

  [[nodiscard]] double along(double at, std::int32_t CircuitPoint::*of) const {
    const double place = std::clamp(at, 0.0, 1.0) * kCircuitSteps;
    const auto k = std::min(static_cast<std::size_t>(place), kCircuitSteps - 1);
    const double low = model.circuit[k].*of, high = model.circuit[k + 1].*of;
    return low + (high - low) * (place - static_cast<double>(k));
  }
  [[nodiscard]] double above(double amperes) const {
    const PartLaw& law = model.by_current;
    return std::clamp(1e3 * std::abs(amperes), double(law.low), double(law.high)) - law.reference;
  }
  [[nodiscard]] Part part(double at, std::int32_t CircuitPoint::*of, std::int32_t per_count, std::int32_t now,
                          double amperes) const {
    const PartLaw& law = model.by_current;
    const double ohm = std::min(250.0 * std::ldexp(along(at, of), -kUnitBits - kOhmBits) * rho, 250.0 / 256.0);
    const double slope = std::ldexp(per_count, -kLawBits), ma = 1e3 * std::abs(amperes);
    const double factor = 1.0 + slope * above(amperes), bends = law.low < ma && ma < law.high ? slope * ma : 0.0;
    return {ohm * factor * unit(now) * amperes, ohm * (factor + bends) * unit(now)};
  }
  [[nodiscard]] double rate(double at, std::int32_t CircuitPoint::*of, std::int32_t per_count, std::int32_t now,
                            double amperes) const {
    const double factor = (1.0 + std::ldexp(per_count, -kLawBits) * above(amperes)) * unit(now);
    return 1e3 * std::ldexp(along(at, of), -kRateBits) / factor;
  }
  [[nodiscard]] Branch branch(double held, const Part& part, double rate) const {
    const double gain = seconds == 0.0 ? 1.0 : -std::expm1(-rate * seconds);
    return {gain, held * (1.0 - gain), std::clamp(part.drop * gain, -4.0, 4.0), part.more * gain};
  }
  /// What warms falls with the resistance on the way; the law of the temperature ends on both sides.
  [[nodiscard]] double risen(double watts, double by_k) const {
    if (joules_per_k == 0.0) return 0.0;
    const double cold = std::min(100.0, std::abs(watts) * seconds / joules_per_k);
    const double rise = cold + by_k * cold * cold / 2.0, now = temperature + warmer;
    const auto within_law = [&](double x) {
      return std::clamp(x, 0.1 * model.by_temperature.low(), 0.1 * model.by_temperature.high());
    };
    return within_law(now + rise) - within_law(now);
  }
  [[nodiscard]] std::pair<double, double> open_circuit(double at) const {
    std::size_t i = 0;
    while (i + 1 < model.intervals && at >= unit(model.ocv_soc[i + 1])) ++i;
    const double slope = 0.25 * std::ldexp(model.ocv_slope[i], -kSlopeBits);
    return {0.25 * std::ldexp(model.ocv[i], -kVoltageBits) + slope * (at - unit(model.ocv_soc[i])), slope};
  }
};

}  // namespace voltlap::bms::test
