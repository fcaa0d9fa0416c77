// SPDX-License-Identifier: Apache-2.0
// A pack whose circuit the filter knows, and a cell that need not be as the filter believes.
#pragma once
#include <cmath>

#include "bms/bench.hpp"

namespace voltlap::bms::test {

/// Straight from 0 to 50 degC, 1 at 25 degC [1e-6 / K].
inline void straight_warmth(const PartSlopes& per_kelvin, Config& c) {
  c.branches.warmth_count = 2;
  for (std::size_t i = 0; i < 2; ++i) {
    const std::int32_t kelvin = i == 0 ? -25 : 25;
    const auto share = [kelvin](std::int32_t slope) { return 1'000'000 + slope * kelvin; };
    c.branches.warmth_at[i] = Temperature::from_raw(i == 0 ? 0 : 500);
    c.branches.warmth[i] = {share(per_kelvin.series), share(per_kelvin.branch1), share(per_kelvin.branch2),
                            share(per_kelvin.time1), share(per_kelvin.time2)};
  }
}

/// pack_config with an OCV that bends, and a circuit of 1 mOhm at once, 0.4 mOhm with 3 s and 0.6 mOhm with 60 s; more
/// towards empty, less when it is warm.
inline Config filtered_config() {
  Config c = pack_config();
  c.soc_method = SocMethod::kEkf;
  c.ocv.count = 5;
  const std::int32_t soc[] = {0, 100'000, 400'000, 700'000, 1'000'000};
  const std::int32_t voltage[] = {30'000, 34'500, 36'500, 37'400, 41'800};
  for (std::size_t i = 0; i < 5; ++i) {
    c.ocv.soc[i] = Soc::from_raw(soc[i]);
    c.ocv.voltage[i] = CellVoltage::from_raw(voltage[i]);
  }
  c.resistance.count = 3;
  c.resistance.soc[1] = Soc::from_raw(200'000);
  c.resistance.soc[2] = Soc::from_raw(1'000'000);
  for (std::size_t i = 0; i < 3; ++i) {
    const std::int32_t percent = i == 0 ? 200 : 100;
    c.resistance.resistance[i] = Resistance::from_raw(20 * percent);
    c.branches.series[i] = Resistance::from_raw(10 * percent);
    c.branches.branch1[i] = Resistance::from_raw(4 * percent);
    c.branches.branch2[i] = Resistance::from_raw(6 * percent);
    c.branches.time1[i] = Duration::from_ms(3'000);
    c.branches.time2[i] = Duration::from_ms(60'000);
  }
  c.branches.current_reference = amps(50);
  c.branches.current_max = amps(300);
  c.branches.per_ampere = {-300, -1'500, 0, -1'000, 0};
  straight_warmth({-10'000, -15'000, -10'000, -5'000, 0}, c);
  return c;
}

/// Exact for a current that is constant over the step, in volts and amperes.
struct TrueCell {
  double soc = 0.9, v1 = 0.0, v2 = 0.0, resistance = 1.0, capacity_ah = 10.0, current = 0.0;

  void advance(double amperes, double seconds) {
    const double bend = 1.0 - 0.0015 * (std::min(std::abs(amperes), 300.0) - 50.0);
    const double slow = 1.0 - 0.001 * (std::min(std::abs(amperes), 300.0) - 50.0);
    const double low = soc < 0.2 ? 2.0 - 5.0 * std::max(soc, 0.0) : 1.0;
    soc -= amperes * seconds / 3600.0 / capacity_ah;
    const auto follow = [&](double& v, double ohm, double tau) {
      v += (resistance * low * ohm * amperes - v) * -std::expm1(-seconds / tau);
    };
    follow(v1, 0.0004 * bend, 3.0 * slow);
    follow(v2, 0.0006, 60.0);
    current = amperes;
  }
  [[nodiscard]] double voltage(const Config& c) const {
    std::size_t i = 1;
    while (i + 1 < c.ocv.count && soc > 1e-6 * c.ocv.soc[i].raw()) ++i;
    const double left = 1e-6 * c.ocv.soc[i - 1].raw(), right = 1e-6 * c.ocv.soc[i].raw();
    const double low = 1e-4 * c.ocv.voltage[i - 1].raw(), high = 1e-4 * c.ocv.voltage[i].raw();
    const double bend = 1.0 - 0.0003 * (std::min(std::abs(current), 300.0) - 50.0);
    const double ends = soc < 0.2 ? 2.0 - 5.0 * std::max(soc, 0.0) : 1.0;
    return low + (high - low) * (soc - left) / (right - left) - v1 - v2 - resistance * ends * 0.001 * bend * current;
  }
};

}  // namespace voltlap::bms::test
