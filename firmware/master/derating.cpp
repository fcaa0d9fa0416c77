// SPDX-License-Identifier: Apache-2.0
#include "master/derating.hpp"

namespace voltlap::master {

Ratio temperature_share(const Sample<Temperature>& temperature, Temperature start, Temperature end) {
  constexpr std::int64_t kFull = 1'000'000;
  if (!temperature.good() || temperature.value >= end) return Ratio{};
  if (temperature.value <= start) return Ratio::from_raw(kFull);
  return Ratio::saturated((end - temperature.value).raw() * kFull / (end - start).raw());
}

Current temperature_ceiling(const Config& config, const Input& input) {
  // MST-034: a temperature that is not known allows nothing.
  const Ratio motor = temperature_share(input.motor_temperature, config.motor_derate_start, config.motor_derate_end);
  const Ratio inverter =
      temperature_share(input.inverter_temperature, config.inverter_derate_start, config.inverter_derate_end);
  return Current::saturated(std::int64_t{config.phase_current_max.raw()} * min(motor, inverter).raw() / 1'000'000);
}

}  // namespace voltlap::master
