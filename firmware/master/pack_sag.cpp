// SPDX-License-Identifier: Apache-2.0
#include "master/pack_sag.hpp"

#include "base/require.hpp"

namespace voltlap::master {
namespace {

constexpr std::int64_t kForget = 64;
constexpr std::int64_t kKnown = 400'000'000;  // [mA^2] a step of 20 A; noise of 1 A leaves a third of it
constexpr std::int64_t kMicroOhmPerUnit = 100'000;  // 0.1 mV / mA = 0.1 ohm

}  // namespace

void watch_pack_sag(const Input& input, PackSag& s) {
  const auto now = [&](const auto& sample) { return sample.good() && (input.now - sample.time).ms() == 0; };
  if (!now(input.pack_current) || !now(input.pack_voltage)) {
    s.followed = false;
    return;
  }
  const std::int64_t di = std::int64_t{input.pack_current.value.raw()} - s.current.raw();
  const std::int64_t du = std::int64_t{input.pack_voltage.value.raw()} - s.voltage.raw();
  if (s.followed) {
    s.squares += di * di - s.squares / kForget;
    s.products += -di * du - s.products / kForget;
  }
  s.followed = true;
  s.current = input.pack_current.value;
  s.voltage = input.pack_voltage.value;
  VOLTLAP_REQUIRE(s.squares >= 0);
}

Resistance pack_resistance(const Config& config, const PackSag& state) {
  if (state.squares < kKnown) return config.pack_resistance;
  // mA^2 in thousands keep the quotient inside 64 bits: products stay below 2e15.
  const std::int64_t micro_ohm = state.products / 1'000 * kMicroOhmPerUnit / (state.squares / 1'000);
  return max(min(Resistance::saturated(micro_ohm), check::kPackResistanceMax), Resistance{});
}

PackVoltage voltage_at(const Config& config, const Input& input, PackVoltage now, Current dc, const PackSag& state) {
  if (!input.pack_current.good()) return now;
  const std::int64_t more_ma = (max(dc, input.pack_current.value) - input.pack_current.value).raw();
  const std::int64_t sag = more_ma * pack_resistance(config, state).raw() / kMicroOhmPerUnit;
  return max(PackVoltage::saturated(now.raw() - sag), PackVoltage::from_raw(now.raw() / 2));
}

}  // namespace voltlap::master
