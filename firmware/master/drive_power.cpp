// SPDX-License-Identifier: Apache-2.0
#include "master/drive_power.hpp"

#include "base/require.hpp"
#include "master/arbitration.hpp"

namespace voltlap::master {
namespace {

constexpr std::int64_t kFull = 1'000'000;
constexpr std::int64_t kMilliwattPerProduct = 10'000;  // mA x 0.1 mV = 0.1 uW
constexpr std::int64_t kHardlyMoved = 50;    // a fiftieth of it a step
constexpr Duration kSteady = Duration::from_ms(50);  // a current controller's 10 ms, and frames of the step before
constexpr std::int64_t kFalls = 4, kRises = 50;      // steps of its time constants: 40 and 500 ms
constexpr std::int64_t kObeysPercent = 95;   // an inverter that gives less than this has a limit of its own
constexpr Ratio kEfficiencyMax = Ratio::from_raw(1'000'000);

// EV.3.3: 100 ms without a break, or a mean of 500 ms. A command acts within two steps.
constexpr Duration kAboveMax = Duration::from_ms(50);
constexpr std::int64_t kMeanMaxMw = 79'700'000;
constexpr Ratio kAboveShare = Ratio::from_raw(850'000);
constexpr Ratio kMeanShare = Ratio::from_raw(970'000);

Duration longer(Duration time, Duration elapsed, Duration most) {
  return min(Duration::from_ms(time.ms() + elapsed.ms()), most);
}

std::int64_t power_mw(const Input& input) {
  if (!input.pack_current.good() || !input.pack_voltage.good()) return 0;
  return std::int64_t{input.pack_current.value.raw()} * input.pack_voltage.value.raw() / kMilliwattPerProduct;
}

void follow_windows(std::int64_t mw, Duration elapsed, DrivePower& s) {
  std::int32_t& oldest = s.power_mw[s.next];
  const auto driving = static_cast<std::int32_t>(max(mw, std::int64_t{0}));
  s.sum_mw += driving - oldest;
  oldest = driving;
  s.next = static_cast<std::uint8_t>((s.next + 1U) % DrivePower::kSteps);
  s.above = mw > check::kPowerMaxMw ? longer(s.above, elapsed, kAboveMax) : Duration{};
  VOLTLAP_REQUIRE(s.sum_mw >= 0);
}

/// What is asked for, or what flows where that is less: at the end of the motor's voltage less than asked for flows.
Current flowing(const Input& input, Current asked) {
  const Current driving = max(asked, Current{});
  if (!input.phase_current.good()) return driving;
  const Current seen = magnitude(input.phase_current.value);
  return seen > Current{} ? min(seen, driving) : driving;
}

/// Once, when it begins: what is asked for while it is held falls by itself.
void hold_what_flows(const Input& input, Current asked, DrivePower& s) {
  if (window_share(s) >= kEfficiencyMax) {
    s.held = Current{};
  } else if (s.held == Current{}) {
    s.held = flowing(input, asked);
  }
}

void follow_steadiness(Current asked, Duration elapsed, DrivePower& s) {
  const std::int64_t moved = magnitude(std::int64_t{asked.raw()} - s.asked_before.raw());
  const bool steady = asked > Current{} && moved * kHardlyMoved <= asked.raw();
  s.steady = steady ? longer(s.steady, elapsed, kSteady) : Duration{};
  s.asked_before = asked;
}

/// Were speed, voltage and current read in this step, and does the inverter do what it is asked to?
bool comparable(const Input& input, Current asked) {
  const auto now = [&](const auto& sample) { return sample.good() && (input.now - sample.time).ms() == 0; };
  if (!now(input.pack_current) || !now(input.pack_voltage) || !now(input.motor_speed)) return false;
  if (!now(input.phase_current)) return false;
  return magnitude(std::int64_t{input.phase_current.value.raw()}) * 100 >= std::int64_t{asked.raw()} * kObeysPercent;
}

}  // namespace

void watch_drive_power(const Config& config, const Input& input, Current asked, bool at_ceiling, Duration elapsed,
                       DrivePower& state) {
  const std::int64_t mw = power_mw(input);
  follow_windows(mw, elapsed, state);
  hold_what_flows(input, asked, state);
  follow_steadiness(asked, elapsed, state);
  if (at_ceiling && state.steady >= kSteady && mw > 0 && comparable(input, asked)) {
    const PackVoltage induced = induced_voltage(config, input.motor_speed.value);
    const std::int64_t shaft_mw = std::int64_t{induced.raw()} * asked.raw() / kMilliwattPerProduct;
    const Ratio seen = max(min(Ratio::saturated(shaft_mw * kFull / mw), kEfficiencyMax), check::kDriveEfficiencyMin);
    const Ratio before = state.efficiency > Ratio{} ? state.efficiency : seen;
    const std::int64_t step = std::int64_t{seen.raw()} - before.raw();
    state.efficiency = Ratio::saturated(before.raw() + step / (step < 0 ? kFalls : kRises));
  }
  state.speed[1] = state.speed[0];
  state.speed[0] = input.motor_speed.value;
}

Ratio drive_efficiency(const Config& config, const Input& input, const DrivePower& state) {
  const bool measured = state.efficiency > Ratio{} && input.pack_current.good() && input.pack_voltage.good();
  return measured ? state.efficiency : min(config.drive_efficiency, state.efficiency > Ratio{} ? state.efficiency
                                                                                              : kEfficiencyMax);
}

MotorSpeed speed_ahead(MotorSpeed now, const DrivePower& state) {
  // A command that is computed now acts a step from now, for a step: one and a half steps on the mean.
  const std::int64_t sign = now.raw() < 0 ? -1 : 1;
  const std::int64_t gained = sign * (std::int64_t{now.raw()} - state.speed[1].raw());
  return gained > 0 ? MotorSpeed::saturated(now.raw() + sign * gained * 3 / 4) : now;
}

Ratio window_share(const DrivePower& state) {
  if (state.above >= kAboveMax) return kAboveShare;
  return state.sum_mw > kMeanMaxMw * static_cast<std::int64_t>(DrivePower::kSteps) ? kMeanShare : kEfficiencyMax;
}

Current share_of(Current current, Ratio share) {
  return Current::saturated(std::int64_t{current.raw()} * share.raw() / kFull);
}

Current within_windows(Current ceiling, const DrivePower& state) {
  const Ratio share = window_share(state);
  const Current left = share_of(ceiling, share);
  return state.held > Current{} ? min(left, share_of(state.held, share)) : left;
}

}  // namespace voltlap::master
