// SPDX-License-Identifier: Apache-2.0
#include "bms/contactors.hpp"

#include "base/require.hpp"

namespace voltlap::bms {
namespace {

using can::BmsState;

constexpr std::int64_t kWhole = 1'000'000;

bool requested(const Measured& m) { return m.master.good() && m.master.value.tractive_system; }
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

void enter(BmsState next, Instant now, Contactors& c) {
  const bool was_open = !c.command.air_plus && !c.command.air_minus && !c.command.precharge;
  c.state = next;
  c.entered = now;
  if (next == BmsState::kPrecharge) {
    c.command = ContactorCommand{false, true, true};
  } else if (next == BmsState::kTsActive) {
    c.command = ContactorCommand{true, true, false};
  } else {
    c.command = ContactorCommand{};
    if (!was_open) c.opened_at = now;
  }
}

void from_invalid(const Config& config, Instant now, State& s) {
  const bool complete = s.pack.complete_once && soc_ready(config, s.soc);
  if (complete && released(s.measured)) enter(BmsState::kIdle, now, s.contactors);
}

void from_idle(const Config& config, Instant now, State& s) {
  if (!requested(s.measured) || !shutdown_closed(s.measured)) return;
  if (!measurements_good(config, s) || !s.measured.dc_link_voltage.good()) return;
  s.contactors.dc_link_was_low = !dc_link_above(s.measured, config.dc_link_welded);
  enter(BmsState::kPrecharge, now, s.contactors);
}

// BMS-031, EV.5.6: the second AIR closes on the measured DC-link voltage, never on time alone.
void from_precharge(const Config& config, Instant now, State& s) {
  Contactors& c = s.contactors;
  const Duration elapsed = now - c.entered;
  if (c.command.air_plus) {
    if (s.measured.io.value.air_plus_aux) enter(BmsState::kTsActive, now, c);
    return;
  }
  if (dc_link_above(s.measured, config.precharge_ratio)) {
    c.precharge_too_fast = c.dc_link_was_low && elapsed < config.precharge_time_min;
    if (c.precharge_too_fast) {
      enter(BmsState::kFault, now, c);
    } else {
      c.command.air_plus = true;
    }
  } else if (elapsed >= config.precharge_timeout) {
    c.precharge_failed = true;
    enter(BmsState::kFault, now, c);
  }
}

void from_open(Instant now, State& s) {
  if (released(s.measured) && all_aux_open(s.measured)) enter(BmsState::kIdle, now, s.contactors);
}

bool closed_or_closing(const Contactors& c) {
  return c.state == BmsState::kPrecharge || c.state == BmsState::kTsActive;
}

/// AIR+ and the precharge relay close only on top of AIR-, and nothing closes outside of precharge and active.
bool command_fits_state(const Contactors& c) {
  const bool any = c.command.air_plus || c.command.air_minus || c.command.precharge;
  return closed_or_closing(c) ? c.command.air_minus : !any;
}

void advance(const Config& config, Instant now, State& state) {
  Contactors& c = state.contactors;
  switch (c.state) {
    case BmsState::kInvalid: from_invalid(config, now, state); break;
    case BmsState::kIdle: from_idle(config, now, state); break;
    case BmsState::kPrecharge: from_precharge(config, now, state); break;
    case BmsState::kTsActive: break;
    case BmsState::kOpen: from_open(now, state); break;
    case BmsState::kFault: enter(BmsState::kOpen, now, c); break;
  }
}

}  // namespace

// BMS-030, EV.7.2.2: whatever asks for open contactors gets them in the same step.
void sequence_contactors(const Config& config, Instant now, State& state) {
  Contactors& c = state.contactors;
  VOLTLAP_REQUIRE(command_fits_state(c));
  c.precharge_failed = false;
  c.precharge_too_fast = false;
  if (state.faults.open && c.state != BmsState::kInvalid) {
    if (c.state != BmsState::kFault) enter(BmsState::kFault, now, c);
  } else if (closed_or_closing(c) && (!requested(state.measured) || !shutdown_closed(state.measured))) {
    enter(BmsState::kOpen, now, c);
  } else {
    advance(config, now, state);
  }
  VOLTLAP_REQUIRE(command_fits_state(c));
}

}  // namespace voltlap::bms
