// SPDX-License-Identifier: Apache-2.0
#include "master/drive_state.hpp"

#include "base/require.hpp"

namespace voltlap::master {
namespace {

void enter(DriveState mode, Instant now, DriveStateState& state) {
  if (state.mode == mode) return;
  state.mode = mode;
  state.entered = now;
}

bool bms_is(const Input& input, BmsState wanted) { return input.bms_state.good() && input.bms_state.value == wanted; }

bool shutdown_closed(const Input& input) { return input.switches.good() && input.switches.value.shutdown_closed; }

void read_buttons(const Input& input, DriveStateState& state) {
  const bool known = input.switches.good();
  state.ts_on.update(known, input.switches.value.ts_on_button);
  state.rtd.update(known, input.switches.value.rtd_button);
  state.reset.update(known, input.switches.value.reset_button);
  const bool begun = state.inverters_wait && state.rtd.rising();
  state.rtd_waits = state.mode == DriveState::kTsActive && state.rtd.held() && (state.rtd_waits || begun);
}

Faults find_faults(const Input& input, const DriveStateState& state) {
  Faults f;
  f.set(MasterFault::kConfigInvalid, !state.config_good || state.refused);  // MST-062
  f.set(MasterFault::kBmsLost, !input.bms_state.good());
  f.set(MasterFault::kVehicleIoLost, !input.switches.good());
  f.set(MasterFault::kInverterLost, !input.inverter_state.good() || state.inverter_dropped);
  // MST-041: an inverter that does not do as it is told is one that has failed, whatever it says of itself.
  f.set(MasterFault::kInverterFault,
        state.inverter_disobeys ||
            (input.inverter_state.good() && input.inverter_state.value == InverterState::kFault));
  f.set(MasterFault::kBmsFault, bms_is(input, BmsState::kFault));
  return f;
}

// MST-010: what may only be left by the reset button.
bool must_latch(Faults f) {
  return f.has(MasterFault::kConfigInvalid) || f.has(MasterFault::kInverterFault) || f.has(MasterFault::kBmsFault);
}

// Where the state goes next while nothing is wrong enough to latch.
DriveState next_mode(const Config& config, const Input& input, const PedalState& pedals,
                     const DriveStateState& state) {
  const bool ts_possible = shutdown_closed(input) && input.bms_state.good();
  switch (state.mode) {
    case DriveState::kInvalid:
    case DriveState::kFault: break;
    case DriveState::kLvOn:
      if (!state.ts_on.rising() || !ts_possible || !bms_is(input, BmsState::kIdle)) return DriveState::kLvOn;
      return DriveState::kTsRequested;
    case DriveState::kTsRequested:
      // MST-011: the shutdown circuit, the BMS or the switches gone: back to low voltage.
      if (!ts_possible) return DriveState::kLvOn;
      if (bms_is(input, BmsState::kTsActive)) return DriveState::kTsActive;
      return input.now - state.entered >= config.ts_request_timeout ? DriveState::kLvOn : DriveState::kTsRequested;
    case DriveState::kTsActive:
      if (!ts_possible || !bms_is(input, BmsState::kTsActive)) return DriveState::kLvOn;
      // MST-012 (EV.9): brake held while the button is pressed, and a pedal box that can be believed.
      return (state.rtd.rising() || state.rtd_waits) && pedals.brake_pressed && pedals.released &&
                     !pedals.latched.any() && !state.inverters_wait
                 ? DriveState::kReadyToDrive
                 : DriveState::kTsActive;
    case DriveState::kReadyToDrive:
      if (ts_possible && state.inverter_dropped) return DriveState::kTsActive;
      return ts_possible && bms_is(input, BmsState::kTsActive) ? DriveState::kReadyToDrive : DriveState::kLvOn;
  }
  return state.reset.held() ? DriveState::kLvOn : DriveState::kFault;
}

}  // namespace

void drive_state_step(const Config& config, const Input& input, const PedalState& pedals, DriveStateState& state) {
  if (state.mode == DriveState::kInvalid) {
    state.config_good = config_check(config) == ConfigError::kNone;
    enter(DriveState::kLvOn, input.now, state);
  }
  read_buttons(input, state);
  state.faults = find_faults(input, state);

  // The reset reaches the BMS only while the tractive system is not wanted; it is a button at the vehicle (EV.7.2.3).
  const bool ts_off = state.mode == DriveState::kLvOn || state.mode == DriveState::kFault;
  state.reset_request = ts_off && state.reset.held();
  const bool failed = must_latch(state.faults);
  enter(failed ? DriveState::kFault : next_mode(config, input, pedals, state), input.now, state);

  VOLTLAP_REQUIRE(state.mode != DriveState::kInvalid);
  VOLTLAP_REQUIRE(state.config_good || state.mode == DriveState::kFault);

  state.ts_request = state.mode == DriveState::kTsRequested || state.mode == DriveState::kTsActive ||
                     state.mode == DriveState::kReadyToDrive;
  // MST-013 (EV.9): the sound, once, when the car becomes ready.
  state.rtd_sound = state.mode == DriveState::kReadyToDrive && input.now - state.entered >= Duration{} &&
                    input.now - state.entered < config.rtd_sound_time;
}

}  // namespace voltlap::master
