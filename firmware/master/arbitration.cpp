// SPDX-License-Identifier: Apache-2.0
#include "master/arbitration.hpp"

#include "base/ramp.hpp"
#include "base/require.hpp"
#include "master/derating.hpp"

namespace voltlap::master {
namespace {

constexpr std::int64_t kFull = 1'000'000;
constexpr std::int64_t kMilliwattPerProduct = 10'000;  // mA x 0.1 mV = 0.1 uW = 1 mW / 10'000

struct Ceiling {
  Current current;
  TorqueReason reason = TorqueReason::kNone;
  void lower_to(Current other, TorqueReason why) {
    if (other >= current) return;
    current = other;
    reason = why;
  }
};

// The voltage that the battery's power comes at: the pack's, else the DC link's.
Sample<PackVoltage> supply_voltage(const Input& input) {
  return input.pack_voltage.good() ? input.pack_voltage : input.dc_link_voltage;
}

// MST-030: a good DC limit as phase current. Without speed or voltage the printed rule remains: phase current <= DC
// limit.
Current battery_ceiling(const Config& config, const Input& input, const Sample<Current>& limit, Ratio efficiency,
                        MotorSpeed speed, const PackSag* sag) {
  VOLTLAP_REQUIRE(limit.good());
  const Sample<PackVoltage> voltage = supply_voltage(input);
  if (config.arbitration == Arbitration::kLiteral || !input.motor_speed.good() || !voltage.good()) {
    return min(limit.value, config.phase_current_max);
  }
  const PackVoltage left =
      sag == nullptr ? voltage.value : voltage_at(config, input, voltage.value, limit.value, *sag);
  return phase_current_for(config, limit.value, left, efficiency, induced_voltage(config, speed));
}

// MST-032 (EV.3.3): P_max eta / E; at the highest speed when the speed is not known.
Current power_ceiling(const Config& config, const Input& input, Ratio efficiency, MotorSpeed ahead) {
  const MotorSpeed speed = input.motor_speed.good() ? ahead : config.motor_speed_max;
  const std::int64_t induced = induced_voltage(config, speed).raw();
  if (induced == 0) return config.phase_current_max;
  const std::int64_t shaft_mw = std::int64_t{config.power_max_mw} * efficiency.raw() / kFull;
  return min(Current::saturated(shaft_mw * kMilliwattPerProduct / induced), config.phase_current_max);
}

// Open above `on`, shut below `off`, as before between them; shut without a good limit.
bool hysteresis(const Config& config, const Sample<Current>& limit, bool open) {
  if (!limit.good() || limit.value < config.battery_limit_off) return false;
  return open || limit.value > config.battery_limit_on;
}

// Measured excess over what the previous command was allowed, as a share: the larger of current and power; not above
// zero where there is none.
Ratio measured_excess(const Config& config, const Input& input, const ArbitrationState& state) {
  if (!input.pack_current.good()) return Ratio{};
  const std::int64_t current = input.pack_current.value.raw();
  const std::int64_t limit = state.discharge_limit_before.raw();
  std::int64_t excess = limit != 0 ? (current - limit) * kFull / limit : 0;
  // A configuration that is refused goes through here too, in the fault state.
  if (input.pack_voltage.good() && config.power_max_mw != 0) {
    const std::int64_t power_mw = current * input.pack_voltage.value.raw() / kMilliwattPerProduct;
    excess = max(excess, (power_mw - config.power_max_mw) * kFull / config.power_max_mw);
  }
  return Ratio::saturated(excess);
}

// MST-033: the losses are an estimate, so a measured excess is integrated into a trim that gives back slowly.
void update_trim(const Config& config, const Input& input, Duration elapsed, ArbitrationState& state) {
  const Ratio excess = measured_excess(config, input, state);
  const Ratio given_back = Ratio::saturated(std::int64_t{config.trim_decay_ppm_per_s} * elapsed.ms() / 1'000);
  const Ratio taken = Ratio::saturated(std::int64_t{excess.raw()} * config.trim_gain.raw() / kFull);
  state.trim = excess > Ratio{} ? min(state.trim + taken, config.trim_max) : max(state.trim - given_back, Ratio{});
}

Current trimmed(Current ceiling, Ratio trim) { return share_of(ceiling, Ratio::from_raw(kFull) - trim); }

Ceiling drive_ceiling(const Config& config, const Input& input, const ArbitrationState& state) {
  Ceiling c{config.phase_current_max};
  const Ratio efficiency = drive_efficiency(config, input, state.power);
  const MotorSpeed speed = speed_ahead(input.motor_speed.value, state.power);
  const Current battery = state.discharge_open
                              ? battery_ceiling(config, input, input.discharge_limit, efficiency, speed, &state.sag)
                              : Current{};
  c.lower_to(trimmed(battery, state.trim), TorqueReason::kDischargeLimit);
  const Current power = within_windows(power_ceiling(config, input, efficiency, speed), state.power);
  c.lower_to(trimmed(power, state.trim), TorqueReason::kPower);
  c.lower_to(temperature_ceiling(config, input), TorqueReason::kTemperature);
  c.lower_to(speed_ceiling(config, input), TorqueReason::kMotorSpeed);
  return c;
}

// Of a car that brakes: a command acts a step from now, for a step, and the inverter's current takes another to go.
Speed speed_when_it_acts(Speed now, Speed before) {
  constexpr std::int32_t kSteps = 3;
  return before > now ? Speed::saturated(std::int64_t{now.raw()} - kSteps * (before - now).raw()) : now;
}

Ceiling regen_ceiling(const Config& config, const Input& input, const ArbitrationState& state) {
  Ceiling c{config.phase_current_max};
  const Current battery = state.charge_open ? battery_ceiling(config, input, input.charge_limit, Ratio::from_raw(kFull),
                                                              input.motor_speed.value, nullptr)
                                            : Current{};
  c.lower_to(battery, TorqueReason::kChargeLimit);
  c.lower_to(temperature_ceiling(config, input), TorqueReason::kTemperature);
  // MST-035 (EV.3.3.3): none below 5 km/h, nor with the speed unknown, nor in reverse.
  const Sample<Speed> speed = lowest_wheel_speed(input);
  const Speed ahead = speed_when_it_acts(speed.value, state.wheels_before);
  const bool fast_enough = speed.good() && ahead > config.regen_speed_min && input.motor_speed.good() &&
                           input.motor_speed.value > MotorSpeed{};
  if (!fast_enough) c.lower_to(Current{}, TorqueReason::kGate);
  return c;
}

// MST-036: down at once, up at the configured rate; the last reason stays until the ceiling is back.
void apply(const Config& config, const Ceiling& target, Duration elapsed, Current& ceiling, TorqueReason& reason) {
  const Ramp<Current> ramp{Current::from_raw(config.ceiling_rise_ma_per_s)};
  ceiling = ramp.toward(target.current, ceiling, elapsed);
  if (ceiling == target.current || reason == TorqueReason::kNone) reason = target.reason;
}

Faults find_faults(const Input& input, const Sample<Speed>& wheels) {
  Faults f;
  f.set(MasterFault::kPackSensorLost, !input.pack_current.good() || !input.pack_voltage.good());
  f.set(MasterFault::kWheelSpeedsLost, !wheels.good());
  f.set(MasterFault::kMotorTemperatureLost, !input.motor_temperature.good() || !input.inverter_temperature.good());
  return f;
}

}  // namespace

PackVoltage induced_voltage(const Config& config, MotorSpeed speed) {
  const std::int64_t rpm = magnitude(std::int64_t{speed.raw()});
  // uV s/rad x rpm x 0.104720 rad/s/rpm = uV; 100 uV a unit. Rounded up, which lowers a ceiling.
  return PackVoltage::saturated((config.motor_constant_unm_per_a * rpm * 104'720 + 99'999'999) / 100'000'000);
}

Current phase_current_for(const Config& config, Current dc, PackVoltage voltage, Ratio efficiency,
                          PackVoltage induced) {
  if (dc <= Current{} || voltage <= PackVoltage{}) return Current{};
  if (induced <= PackVoltage{}) return config.phase_current_max;
  const std::int64_t usable = std::int64_t{dc.raw()} * efficiency.raw() / kFull;
  return min(Current::saturated(usable * voltage.raw() / induced.raw()), config.phase_current_max);
}

Sample<Speed> lowest_wheel_speed(const Input& input) {
  Speed lowest{};
  int good = 0;
  for (const Sample<Speed>& wheel : input.wheel_speed) {
    if (!wheel.good()) continue;
    lowest = good == 0 ? wheel.value : min(lowest, wheel.value);
    ++good;
  }
  return Sample<Speed>{lowest, input.now, good < 2 ? Quality::kInvalid : Quality::kGood};
}

void arbitration_step(const Config& config, const Input& input, Current request, Duration elapsed,
                      ArbitrationState& state) {
  VOLTLAP_REQUIRE(elapsed >= Duration{});
  const Sample<Speed> wheels = lowest_wheel_speed(input);
  state.faults = find_faults(input, wheels);
  const bool at_ceiling = state.reason == TorqueReason::kPower || state.reason == TorqueReason::kDischargeLimit;
  watch_drive_power(config, input, state.current, at_ceiling, elapsed, state.power);
  watch_pack_sag(input, state.sag);
  update_trim(config, input, elapsed, state);
  state.discharge_open = hysteresis(config, input.discharge_limit, state.discharge_open);
  state.charge_open = hysteresis(config, input.charge_limit, state.charge_open);

  apply(config, drive_ceiling(config, input, state), elapsed, state.drive_ceiling, state.drive_reason);
  apply(config, regen_ceiling(config, input, state), elapsed, state.regen_ceiling, state.regen_reason);
  state.wheels_before = wheels.good() ? wheels.value : Speed{};
  state.discharge_limit_before = input.discharge_limit.good() ? input.discharge_limit.value : Current{};

  // MST-031 (Eq. 4.13): the request where it is below its ceiling, else the ceiling; the sign never changes.
  state.current = max(min(request, state.drive_ceiling), -state.regen_ceiling);
  state.reason = TorqueReason::kNone;
  if (request > state.current) state.reason = state.drive_reason;
  if (request < state.current) state.reason = state.regen_reason;
}

}  // namespace voltlap::master
