// SPDX-License-Identifier: Apache-2.0
#include "bms/temperature_check.hpp"

#include "base/require.hpp"
#include "bms/slow_mean.hpp"
#include "bms/state.hpp"

namespace voltlap::bms {
namespace {

constexpr Duration kSlow = Duration::from_ms(5'000);            // chosen with kRateMax: 1.6 K/s for good
constexpr Temperature kRateMax = Temperature::from_raw(80);     // 8 K; a cell at 10 times its rated loss does 0.5 K/s
constexpr Temperature kSpreadMax = Temperature::from_raw(250);  // 25 K; chosen: twice the spread of an air-cooled pack

std::int32_t size(std::int32_t x) { return x < 0 ? -x : x; }

bool too_fast(Temperature value, Instant now, TemperatureTrack& t) {
  const std::int32_t scaled = value.raw() * 256;
  if (!t.begun) t.slow = scaled;
  t.begun = true;
  t.slow = static_cast<std::int32_t>(follow(t.slow, scaled, share_of(now - t.time, kSlow)));
  t.time = now;
  return size(scaled - t.slow) > kRateMax.raw() * 256;
}

}  // namespace

// BMS-064
void check_temperatures(const Config& config, Instant now, State& s) {
  VOLTLAP_REQUIRE(config.temperature_sensors > 0 && config.temperature_sensors <= kMaxTemperatures);
  // Between two frames there is nothing new; what is lost is told by BMS-014.
  if (!s.measured.temperatures_arrived) return;
  TemperatureCheck& c = s.temperature_check;
  std::int32_t sum = 0, count = 0;
  for (std::size_t i = 0; i < config.temperature_sensors; ++i) {
    const Sample<Temperature>& sample = s.measured.temperature[i];
    if (!sample.good()) continue;
    sum += sample.value.raw();
    ++count;
    if ((now - sample.time).ms() != 0) continue;
    const bool fast = too_fast(sample.value, now, c.sensor[i]);
    if (fast) {
      c.too_fast = static_cast<std::uint8_t>(i);
    } else if (c.too_fast == i) {
      c.too_fast = kNoCell;
    }
  }
  c.apart = kNoCell;
  for (std::size_t i = 0; count > 2 && i < config.temperature_sensors; ++i) {
    const Sample<Temperature>& sample = s.measured.temperature[i];
    if (!sample.good()) continue;
    // Times the number of the others: from their mean, without a division.
    const std::int32_t others = sum - sample.value.raw();
    const std::int32_t away = size(sample.value.raw() * (count - 1) - others);
    if (away > kSpreadMax.raw() * (count - 1)) c.apart = static_cast<std::uint8_t>(i);
  }
}

}  // namespace voltlap::bms
