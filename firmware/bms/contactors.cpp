// SPDX-License-Identifier: Apache-2.0
#include "bms/contactors.hpp"

#include "base/require.hpp"
#include "bms/charge/on_charger.hpp"

namespace voltlap::bms {
namespace {

using can::BmsState;

constexpr std::int64_t kWhole = 1'000'000;
constexpr Duration kPlugged = Duration::from_ms(500);  // chosen: a contact that bounces does not stop a driving car

bool requested(const Measured& m) { return m.master.good() && m.master.value.tractive_system; }
/// For what they are closed, somebody still wants it. A car on a charger does not drive.
bool wanted(const State& s) {
  if (s.contactors.for_charge) return s.charge.wants_contactors;
  return requested(s.measured) && !s.contactors.plugged_in;
}
bool released(const Measured& m) { return m.master.good() && !m.master.value.tractive_system; }
bool shutdown_closed(const Measured& m) { return m.io.good() && m.io.value.shutdown_closed; }

bool all_aux_open(const Measured& m) {
  const VehicleIo& io = m.io.value;
  return m.io.good() && !io.air_plus_aux && !io.air_minus_aux && !io.precharge_aux;
}

bool measurements_good(const Config& config, const State& s) {
  return s.pack.cells_good && s.pack.temperatures_good && s.measured.current.good() &&
         s.measured.pack_voltage.good() && soc_ready(config, s.soc);
}

/// DC link at or above `ratio` of the pack voltage, both measured.
bool dc_link_above(const Measured& m, Ratio ratio) {
  if (!m.dc_link_voltage.good() || !m.pack_voltage.good() || m.pack_voltage.value <= PackVoltage{}) return false;
  return std::int64_t{m.dc_link_voltage.value.raw()} * kWhole >= std::int64_t{m.pack_voltage.value.raw()} * ratio.raw();
}

void open_all(Instant now, Contactors& c) {
  if (commanded(c.command)) c.opened_at = now;
  c.command = ContactorCommand{};
  c.opening = false;
}

/// Leaves a state in which contactors are closed or closing. The torque goes first.
void leave(BmsState next, Instant now, Contactors& c) {
  c.opening = c.state == BmsState::kTsActive || c.state == BmsState::kCharging;
  c.opening_since = now;
  if (!c.opening) open_all(now, c);
  c.state = next;
}

void enter(BmsState next, Instant now, Contactors& c) {
  c.state = next;
  c.entered = now;
  if (next == BmsState::kPrecharge) {
    c.command = ContactorCommand{false, true, true};
    c.closed_once = true;
  } else if (next == BmsState::kTsActive || next == BmsState::kCharging) {
    c.command = ContactorCommand{true, true, false};
  } else {
    open_all(now, c);
  }
}

// BMS-034: limits are zero since the step that asked for it; the contactors follow the current, or the time.
void open_after_torque(const Config& config, Instant now, State& s) {
  Contactors& c = s.contactors;
  if (!c.opening) return;
  const Sample<Current>& current = s.measured.current;
  const bool gone = current.good() && current.value <= config.opening_current &&
                    -current.value <= config.opening_current;
  if (gone || now - c.opening_since >= config.opening_time) open_all(now, c);
}

// BMS-033: every precharge warms its resistor; it gives back one after each time of cooling.
void cool_down(const Config& config, Instant now, Contactors& c) {
  if (c.precharges == 0 || now - c.credit_at < config.precharge_cooling) return;
  --c.precharges;
  c.credit_at = now;
}

void from_invalid(const Config& config, Instant now, State& s) {
  const bool complete = s.pack.complete_once && soc_ready(config, s.soc);
  // With a contact that says closed the reading with open contactors is not known; the fault of the contact is told.
  const bool offset_known = s.current_check.offset_known || (s.measured.io.good() && !all_aux_open(s.measured));
  if (complete && offset_known && released(s.measured)) enter(BmsState::kIdle, now, s.contactors);
}

// BMS-032: a DC link that reads charged, and that nothing here has charged, is waited for; it trips when it stays.
bool dc_link_explained(const Config& config, const State& s) {
  return s.contactors.closed_once || !dc_link_above(s.measured, config.dc_link_welded);
}

void from_idle(const Config& config, Instant now, State& s) {
  Contactors& c = s.contactors;
  c.for_charge = s.charge.wants_contactors;
  if (!wanted(s) || !shutdown_closed(s.measured) || (!c.for_charge && on_charger(s.measured))) return;
  if (s.measured.io.value.isolation_fault) return;  // BMS-036
  if (!measurements_good(config, s) || !s.measured.dc_link_voltage.good()) return;
  if (!dc_link_explained(config, s) || c.precharges >= config.precharge_attempts) return;
  if (c.precharges == 0) c.credit_at = now;
  ++c.precharges;
  c.dc_link_was_low = !dc_link_above(s.measured, config.dc_link_welded);
  c.path_closed = false;
  enter(BmsState::kPrecharge, now, c);
}

/// Nothing rises before the contacts have travelled: their time is no part of that of the resistor.
void note_path(Instant now, const VehicleIo& io, Contactors& c) {
  if (c.path_closed || !io.air_minus_aux || !io.precharge_aux) return;
  c.path_closed = true;
  c.path_closed_at = now;
}

// BMS-018: up in no time, through a welded AIR+ and no resistor.
bool too_fast(const Config& config, Instant now, const Contactors& c) {
  return c.dc_link_was_low && now - (c.path_closed ? c.path_closed_at : c.entered) < config.precharge_time_min;
}

// BMS-031, EV.5.6: the second AIR closes on the measured DC-link voltage, never on time alone.
void from_precharge(const Config& config, Instant now, State& s) {
  Contactors& c = s.contactors;
  VOLTLAP_REQUIRE(s.measured.io.good());  // lost news of the shutdown circuit has opened already
  const Duration elapsed = now - c.entered;
  if (c.command.air_plus) {
    // BMS-051: closed for a charger is another state, for which no torque is given.
    if (s.measured.io.value.air_plus_aux) enter(c.for_charge ? BmsState::kCharging : BmsState::kTsActive, now, c);
    return;
  }
  note_path(now, s.measured.io.value, c);
  // BMS-032: what was not seen to rise has the time in which it rises.
  const bool seen = c.dc_link_was_low || elapsed >= config.precharge_time_unseen;
  if (dc_link_above(s.measured, config.precharge_ratio) && seen) {
    c.precharge_too_fast = too_fast(config, now, c);
    if (c.precharge_too_fast) {
      enter(BmsState::kFault, now, c);
    } else {
      c.command.air_plus = true;
    }
  } else if (elapsed >= config.precharge_timeout && seen) {
    c.precharge_failed = true;
    enter(BmsState::kFault, now, c);
  }
}

void from_open(Instant now, State& s) {
  if (s.contactors.opening || (s.contactors.for_charge && on_charger(s.measured))) return;
  if (released(s.measured) && all_aux_open(s.measured)) enter(BmsState::kIdle, now, s.contactors);
}

bool closed_or_closing(const Contactors& c) {
  return c.state == BmsState::kPrecharge || c.state == BmsState::kTsActive || c.state == BmsState::kCharging;
}

/// AIR+ and the precharge relay close only on top of AIR-, and nothing is closed outside of precharge and active but
/// what opens after the torque.
bool command_fits_state(const Contactors& c) {
  return closed_or_closing(c) || c.opening ? c.command.air_minus : !commanded(c.command);
}

void advance(const Config& config, Instant now, State& state) {
  Contactors& c = state.contactors;
  switch (c.state) {
    case BmsState::kInvalid: from_invalid(config, now, state); break;
    case BmsState::kIdle: from_idle(config, now, state); break;
    case BmsState::kPrecharge: from_precharge(config, now, state); break;
    case BmsState::kTsActive:
    case BmsState::kCharging: break;
    case BmsState::kOpen: from_open(now, state); break;
    case BmsState::kFault:
      if (!c.opening) enter(BmsState::kOpen, now, c);
      break;
  }
}

}  // namespace

// BMS-030, EV.7.2.2: an open shutdown circuit, and whatever cannot wait, opens in the same step.
void sequence_contactors(const Config& config, Instant now, State& state) {
  Contactors& c = state.contactors;
  VOLTLAP_REQUIRE(command_fits_state(c));
  c.precharge_failed = false;
  c.precharge_too_fast = false;
  cool_down(config, now, c);
  c.plugged_in = c.plugged.held(on_charger(state.measured), now, kPlugged);
  const bool at_once = state.faults.open_now || !shutdown_closed(state.measured);
  if (state.faults.open && c.state != BmsState::kInvalid) {
    if (closed_or_closing(c)) leave(BmsState::kFault, now, c);
    c.state = BmsState::kFault;
  } else if (closed_or_closing(c) && (!wanted(state) || !shutdown_closed(state.measured))) {
    leave(BmsState::kOpen, now, c);
  } else {
    advance(config, now, state);
  }
  if (at_once) open_all(now, c);
  open_after_torque(config, now, state);
  VOLTLAP_REQUIRE(command_fits_state(c));
}

}  // namespace voltlap::bms
