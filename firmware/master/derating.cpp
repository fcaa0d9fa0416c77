// SPDX-License-Identifier: Apache-2.0
#include "master/derating.hpp"

namespace voltlap::master {

Ratio temperature_share(const Sample<Temperature>& temperature, Temperature start, Temperature end, Ratio unknown) {
  constexpr std::int64_t kFull = 1'000'000;
  if (!temperature.good()) return unknown;
  if (temperature.value >= end) return Ratio{};
  if (temperature.value <= start) return Ratio::from_raw(kFull);
  return Ratio::saturated((end - temperature.value).raw() * kFull / (end - start).raw());
}

Current temperature_ceiling(const Config& config, const Input& input) {
  // MST-034: a temperature that is not known allows nothing, or what the team has set to drive home with.
  const Ratio limp = config.limp_share;
  const Ratio motor =
      temperature_share(input.motor_temperature, config.motor_derate_start, config.motor_derate_end, limp);
  const Ratio inverter =
      temperature_share(input.inverter_temperature, config.inverter_derate_start, config.inverter_derate_end, limp);
  return Current::saturated(std::int64_t{config.phase_current_max.raw()} * min(motor, inverter).raw() / 1'000'000);
}

// MST-038
Current speed_ceiling(const Config& config, const Input& input) {
  const std::int64_t highest = config.motor_speed_max.raw();
  if (!input.motor_speed.good()) return config.phase_current_max;
  const std::int64_t left = highest - magnitude(std::int64_t{input.motor_speed.value.raw()});
  const std::int64_t taper = highest / 50;
  if (left <= 0) return Current{};
  if (left >= taper) return config.phase_current_max;
  return Current::saturated(config.phase_current_max.raw() * left / taper);
}

}  // namespace voltlap::master
