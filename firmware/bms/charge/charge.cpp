// SPDX-License-Identifier: Apache-2.0
#include "bms/charge/charge.hpp"

#include "base/require.hpp"
#include "bms/charge/balancing.hpp"
#include "bms/charge/cell_look.hpp"
#include "bms/charge/charge_config.hpp"
#include "bms/charge/on_charger.hpp"
#include "bms/charge/progress.hpp"
#include "bms/faults.hpp"

namespace voltlap::bms {
namespace {

using can::ChargePhase;
using can::ChargeReason;

// Of the hold. Charger, frame and reading answer within 2 s; at 2 C a cell's voltage rises by 1 mV/s, and what the hold
// runs behind it is 4 mV.
constexpr std::int32_t kRiseMs = 20'000, kFallMs = 4'000;
constexpr Duration kSteerMost = Duration::from_ms(1'000);
constexpr Duration kHeld = Duration::from_ms(10'000);
constexpr Duration kRest = Duration::from_ms(20'000);         // after the end current and after a bleed
constexpr Duration kBleed = Duration::from_ms(120'000);       // 4 mAh; so long no cell is read without its bleed
constexpr Duration kNotConnected = Duration::from_ms(5'000);  // the charger tells every second, and finds out in 5 s
constexpr Duration kNotAsked = Duration::from_ms(5'000);      // a charger's output falls within 3 s
constexpr Duration kNoCurrent = Duration::from_ms(600'000);
constexpr Current kNone = Current::from_raw(50);  // half of the charger's step
constexpr Current kNotAskedLeast = Current::from_raw(1'000);  // 1 A: offset of the sensor, steps of the charger
constexpr Duration kIdle = Duration::from_ms(3'600'000);  // neither charged nor bled: cells that are to cool
constexpr Duration kLingers = Duration::from_ms(5'000);       // after it the charger has stopped by itself
constexpr std::int32_t kWindup_ua = 300'000;                  // 0.3 A; chosen, more than the charger's steps

bool runs(ChargePhase phase) {
  return phase == ChargePhase::kCharging || phase == ChargePhase::kResting || phase == ChargePhase::kBleeding;
}

void enter(ChargePhase next, Instant now, Charge& c) {
  if (c.asked > Current{}) c.at_once = true;
  c.phase = next;
  c.reason = ChargeReason::kNone;
  c.entered = now;
  c.asked = Current{};
  c.hold_ua = 0;
  c.steered = now;
  c.held = Persistence{};
  begin_progress(now, c.progress);
}

void end(ChargePhase phase, ChargeReason why, Instant now, Charge& c) {
  enter(phase, now, c);
  c.reason = why;
  c.wants_contactors = false;
}

bool shutdown_open(const Measured& m) { return !m.io.good() || !m.io.value.shutdown_closed; }
bool drive_requested(const Measured& m) { return !m.master.good() || m.master.value.tractive_system; }

/// At rest or with shunts that may not be on, for too long.
ChargeReason idle_by(const Config& config, Instant now, State& s) {
  Charge& c = s.charge;
  if (c.phase == ChargePhase::kCharging || s.cells_bled > 0) c.did = now;
  if (now - c.did < kIdle) return ChargeReason::kNone;
  if (too_hot_to_bleed(config, s)) return ChargeReason::kTemperature;
  const Current size = max(s.measured.current.value, -s.measured.current.value);
  return size > config.balancing_current_max ? ChargeReason::kCurrentNotAsked : ChargeReason::kMeasurementLost;
}

/// What a charge cannot begin with, nor go on.
ChargeReason forbidden_by(const State& s) {
  if (s.faults.open || is_set(s.faults, can::BmsFault::kForeignFrames)) return ChargeReason::kFault;
  if (shutdown_open(s.measured)) return ChargeReason::kShutdownCircuit;
  if (drive_requested(s.measured)) return ChargeReason::kRequestReleased;
  if (!s.measured.charger.good()) return ChargeReason::kChargerSilent;  // BMS-053
  return s.measured.charger.value.faulty ? ChargeReason::kChargerFault : ChargeReason::kNone;
}

ChargeReason waits_for_charge(const Config& config, const State& s) {
  if (config.charger_current_max == Current{}) return ChargeReason::kNoChargerInPack;
  const bool known = s.pack.cells_good && s.pack.temperatures_good && s.measured.current.good() &&
                     s.contactors.state != can::BmsState::kInvalid;
  if (!known) return ChargeReason::kMeasurementLost;
  const bool cold = s.pack.temperature_min < config.charge_temperature_min;
  if (cold || s.pack.temperature_max >= config.derating_start) return ChargeReason::kTemperature;
  return forbidden_by(s);
}

/// Into the pack or out of it, what was not asked for: BMS-054.
bool flows_unasked(const Charge& c, Current charging) {
  const Current most = c.asked + Current::from_raw(c.asked.raw() / 20) + kNotAskedLeast;
  return charging > most || -charging > kNotAskedLeast;
}

ChargeReason broken_off_by(Instant now, State& s) {
  Charge& c = s.charge;
  const ChargeReason forbidden = forbidden_by(s);
  if (forbidden != ChargeReason::kNone) return forbidden;
  if (!charges(s)) return ChargeReason::kContactorsOpened;
  if (!s.measured.current.good()) return ChargeReason::kMeasurementLost;
  const Current charging = -s.measured.current.value;
  if (c.not_asked.held(flows_unasked(c, charging), now, kNotAsked)) return ChargeReason::kCurrentNotAsked;
  if (c.not_connected.held(s.measured.charger.value.not_connected, now, kNotConnected)) {
    return ChargeReason::kChargerNotConnected;
  }
  const bool asks = c.asked > Current{};
  if (c.no_current.held(asks && charging < kNone, now, kNoCurrent)) return ChargeReason::kNoCurrent;
  return ChargeReason::kNone;
}

/// The hold goes on from what flows when it must fall: a charger that gives less than it is asked for has wound it up.
void steer(const Config& config, Instant now, State& s) {
  Charge& c = s.charge;
  const Duration elapsed = min(max(now - c.steered, Duration{}), kSteerMost);
  c.steered = now;
  const std::int64_t room = (charge_voltage(config) - s.look.highest_now).raw();
  const std::int64_t ohm = s.cell_resistance.raw();
  if (ohm <= 0) return;
  std::int64_t hold = c.hold_ua;
  const std::int64_t flows = std::int64_t{-s.measured.current.value.raw()} * 1'000 + kWindup_ua;
  if (room < 0 && hold > flows) hold = flows;
  hold += room * 100'000'000 / ohm * elapsed.ms() / (room < 0 ? kFallMs : kRiseMs);  // 0.1 mV / uOhm is 100 A
  const std::int64_t most = std::int64_t{config.charger_current_max.raw()} * 1'000;
  c.hold_ua = static_cast<std::int32_t>(hold < 0 ? 0 : (hold > most ? most : hold));
}

// BMS-052
void ask(const Config& config, State& s) {
  Charge& c = s.charge;
  const Current hold = Current::from_raw(c.hold_ua / 1'000);
  const Current ceiling = min(s.limits.charge.value, config.charger_current_max);
  const bool limited = ceiling < kChargerStep;
  const bool heat = s.limits.charge.reason == can::LimitReason::kTemperature;
  c.reason = !limited ? ChargeReason::kNone : (heat ? ChargeReason::kTemperature : ChargeReason::kLimit);
  const Current asked = Current::from_raw(min(hold, ceiling).raw() / kChargerStep.raw() * kChargerStep.raw());
  if (c.asked > Current{} && asked == Current{}) c.at_once = true;
  c.asked = asked;
}

void charge_on(const Config& config, Instant now, Duration elapsed, bool slow, State& s) {
  Charge& c = s.charge;
  count_progress(config, elapsed, s);
  follow_highest(config, (c.steered - c.entered).ms() == 0, s);  // anew until it is first steered by
  if (!slow) return;
  steer(config, now, s);
  ask(config, s);
  const bool reached = charge_voltage(config) - s.look.highest_now <= held_within(s.cell_resistance);
  const bool small = Current::from_raw(c.hold_ua / 1'000) <= config.charge_current_end;
  const Gain gain = judge_progress(config, now, s);
  if (gain == Gain::kNone) {
    end(ChargePhase::kStopped, c.reason == ChargeReason::kNone ? ChargeReason::kNoCurrent : c.reason, now, c);
    return;
  }
  if (!c.held.held(reached && small, now, kHeld) && gain != Gain::kFull) return;
  enter(ChargePhase::kResting, now, c);
  c.after_charging = true;
  begin_look(s.look);
}

bool time_is_over(const Config& config, const Charge& c) { return c.bled_ms >= config.balancing_time_max.ms(); }

// BMS-058
/// What was bled is charged again before it ends, so that the pack is left full.
void give_up(const Config& config, ChargeReason why, Instant now, State& s) {
  Charge& c = s.charge;
  if (c.last == ChargeReason::kNone) c.off_cell = farthest_cell(config, s.look);
  c.last = why;
  if (c.after_charging) {
    end(ChargePhase::kStopped, why, now, c);
  } else {
    enter(ChargePhase::kCharging, now, c);
  }
}

/// What the look says is to be done.
void decide(const Config& config, Instant now, State& s) {
  Charge& c = s.charge;
  const bool even = s.look.highest - s.look.lowest <= config.balancing_difference;
  s.look.rested = !c.after_charging;
  if (c.after_charging) set_floor(s.look);
  const bool nearer = come_nearer(s.look.highest - s.look.lowest, c);
  if (even && c.after_charging) {
    end(ChargePhase::kFull, ChargeReason::kNone, now, c);
  } else if (even) {
    enter(ChargePhase::kCharging, now, c);
  } else if (c.last != ChargeReason::kNone) {
    give_up(config, c.last, now, s);
  } else if (time_is_over(config, c)) {
    give_up(config, ChargeReason::kBalancingTime, now, s);
  } else if (!nearer) {
    give_up(config, ChargeReason::kUneven, now, s);
  } else if (some_to_bleed(config, s.look)) {
    enter(ChargePhase::kBleeding, now, c);
  } else if (c.after_charging) {
    give_up(config, ChargeReason::kNotBalanced, now, s);
  } else {
    enter(ChargePhase::kCharging, now, c);  // each has lost what it had too much
  }
}

void rest_on(const Config& config, Instant now, State& s) {
  const bool quiet = s.measured.current.value <= config.balancing_current_max &&
                     -s.measured.current.value <= config.balancing_current_max;
  if (!quiet || s.measured.some_bled) begin_look(s.look);
  if (now - s.charge.entered < kRest || !quiet) return;
  if (take_look(config, s)) decide(config, now, s);
}

void bleed_on(const Config& config, Instant now, Duration elapsed, State& s) {
  Charge& c = s.charge;
  c.reason = too_hot_to_bleed(config, s) ? ChargeReason::kTemperature : ChargeReason::kNone;
  if (s.cells_bled > 0) c.bled_ms += elapsed.ms();
  if (now - c.entered < kBleed && !time_is_over(config, c)) return;
  enter(ChargePhase::kResting, now, c);
  c.after_charging = false;
  begin_look(s.look);
}

void wait_on(const Config& config, Instant now, State& s) {
  Charge& c = s.charge;
  c.reason = waits_for_charge(config, s);
  c.wants_contactors = c.reason == ChargeReason::kNone;
  c.did = now;
  if (c.wants_contactors && charges(s)) enter(ChargePhase::kCharging, now, c);
}

/// The charger is told for as long as it would go on by itself.
void switched_off(Instant now, State& s) {
  const bool was_on = s.charge.phase != ChargePhase::kNone;
  const Instant since = was_on ? now : s.charge.entered;
  const bool lingers = was_on || (s.charge.lingers && now - since < kLingers);
  if (!was_on && s.charge.lingers == lingers) return;
  s.charge = Charge{};
  s.charge.entered = since;
  s.charge.lingers = lingers;
  s.charge.at_once = was_on;
  s.look.known = false;
}

}  // namespace

void run_charge(const Config& config, Instant now, Duration elapsed, bool slow, State& state) {
  Charge& c = state.charge;
  c.at_once = false;
  state.look.rested = false;
  if (state.measured.io.good() && !state.measured.io.value.charge_switch) {
    switched_off(now, state);
    return;
  }
  if (!on_charger(state.measured) && c.phase == ChargePhase::kNone) return;
  if (c.phase == ChargePhase::kNone) enter(ChargePhase::kWaiting, now, c);
  if (c.phase == ChargePhase::kWaiting) wait_on(config, now, state);
  if (!runs(c.phase)) return;
  ChargeReason broken = broken_off_by(now, state);
  if (broken == ChargeReason::kNone) broken = idle_by(config, now, state);
  if (broken != ChargeReason::kNone) {
    end(ChargePhase::kStopped, broken, now, c);
    return;
  }
  if (c.phase == ChargePhase::kCharging) {
    charge_on(config, now, elapsed, slow, state);
  } else if (c.phase == ChargePhase::kResting) {
    rest_on(config, now, state);
  } else {
    bleed_on(config, now, elapsed, state);
  }
  VOLTLAP_REQUIRE(c.asked == Current{} || (c.phase == ChargePhase::kCharging && c.asked <= config.charger_current_max));
}

}  // namespace voltlap::bms
