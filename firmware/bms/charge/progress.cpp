// SPDX-License-Identifier: Apache-2.0
#include "bms/charge/progress.hpp"

#include "base/require.hpp"
#include "bms/charge/charge_config.hpp"

namespace voltlap::bms {
namespace {

constexpr CellVoltage kReached = CellVoltage::from_raw(20);  // 2 mV
constexpr Duration kWindow = Duration::from_ms(600'000);
constexpr Current kLeast = Current::from_raw(50);  // half of the charger's step
constexpr std::uint8_t kCoolingMost = 6;           // windows: an hour
constexpr std::int64_t kMsPerHour = 3'600'000;

constexpr std::int32_t kBledMost_ms = 3 * 3'600'000;              // 0.13 A in 150 Ah: 2 mV at the end of a curve
constexpr CellVoltage kNearer = CellVoltage::from_raw(15);        // more than the noise of two looks
constexpr CellVoltage kFurther = CellVoltage::from_raw(100);
constexpr CellVoltage kRoundNearer = CellVoltage::from_raw(5);
constexpr std::uint8_t kFruitlessMost = 3;

Current least_gain(const Config& config) {
  const Current share = max(kLeast, Current::from_raw(config.capacity_mah / 1'000));
  return min(share, Current::from_raw(config.charger_current_max.raw() / 2));
}

std::int64_t in_window(Current current) { return current.raw() * kWindow.ms(); }

bool round_is_nearer(CellVoltage spread, BalancingProgress& b) {
  b.known = false;
  const bool nearer = !b.round_known || spread <= b.round - kRoundNearer;
  b.round = nearer ? spread : b.round;
  b.round_known = true;
  b.fruitless = nearer ? std::uint8_t{0} : static_cast<std::uint8_t>(b.fruitless + 1);
  return b.fruitless < kFruitlessMost;
}

}  // namespace

CellVoltage held_within(Resistance resistance) {
  const std::int64_t two_steps = std::int64_t{2} * kChargerStep.raw() * resistance.raw() / 100'000;  // mA uOhm is nV
  return max(kReached, CellVoltage::saturated(two_steps));
}

void begin_progress(Instant now, ChargeProgress& progress) {
  progress = ChargeProgress{};
  progress.since = now;
}

void count_progress(const Config& config, Duration elapsed, State& state) {
  ChargeProgress& p = state.charge.progress;
  const Current charging = -state.measured.current.value;
  p.gained += charging.raw() * elapsed.ms();
  p.total += charging.raw() * elapsed.ms();
  const Current little = max(config.charge_current_end, kChargerStep) + kChargerStep;
  const bool known = (state.charge.steered - state.charge.entered).ms() != 0;  // look.highest_now is of this charge
  const bool at_voltage = charge_voltage(config) - state.look.highest_now <= held_within(state.cell_resistance);
  p.reached = p.reached || (known && at_voltage && charging <= little);
}

// BMS-056
Gain judge_progress(const Config& config, Instant now, State& state) {
  ChargeProgress& p = state.charge.progress;
  VOLTLAP_REQUIRE(config.capacity_mah > 0);
  if (p.total > config.capacity_mah * kMsPerHour / 4 * 5) return p.reached ? Gain::kFull : Gain::kNone;
  if (now - p.since < kWindow) return Gain::kSome;
  const bool grows = p.gained >= in_window(least_gain(config));
  if (p.reached && p.gained < in_window(max(least_gain(config), config.charge_current_end))) return Gain::kFull;
  const bool hot = state.charge.reason == can::ChargeReason::kTemperature;
  if (!grows && !(hot && p.cooling < kCoolingMost)) return Gain::kNone;
  p.cooling = grows ? std::uint8_t{0} : static_cast<std::uint8_t>(p.cooling + 1);
  p.since = now;
  p.gained = 0;
  p.reached = false;
  return Gain::kSome;
}

// BMS-058
bool come_nearer(CellVoltage spread, Charge& charge) {
  BalancingProgress& b = charge.balancing;
  if (charge.after_charging) return round_is_nearer(spread, b);
  if (!b.known || spread <= b.least - kNearer) {
    b.least = spread;
    b.least_at_ms = charge.bled_ms;
    b.known = true;
  }
  return charge.bled_ms - b.least_at_ms < kBledMost_ms && spread <= b.least + kFurther;
}

}  // namespace voltlap::bms
