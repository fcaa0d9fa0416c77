// SPDX-License-Identifier: Apache-2.0
#include "master/master_step.hpp"

#include "base/require.hpp"
#include "master/inverter_command.hpp"
#include "master/command_veto.hpp"

namespace voltlap::master {
namespace {

// Time since the last step: 0 at the first and when time runs back, never more than kStepMax.
Duration advance(Instant now, State& state) {
  const Duration elapsed = state.started ? now - state.last_step : Duration{};
  state.started = true;
  state.last_step = now;
  return max(min(elapsed, kStepMax), Duration{});
}

// What is older than torque may rest on is told as lost, though the drive state outlives a longer gap.
Faults late_inputs(const Config& config, const Input& input) {
  const auto late = [&](const auto& sample) { return sample.good() && input.now - sample.time >= config.rx_timeout; };
  Faults f;
  f.set(MasterFault::kPedalsLost, late(input.apps1) || late(input.apps2));
  f.set(MasterFault::kBmsLost, late(input.bms_state) || late(input.discharge_limit) || late(input.charge_limit));
  f.set(MasterFault::kVehicleIoLost, late(input.switches));
  // One that hears no commands is as lost as one that is not heard.
  const bool deaf = input.inverter_state.value == InverterState::kCommandTimeout;
  f.set(MasterFault::kInverterLost, late(input.inverter_state) || deaf);
  f.set(MasterFault::kForeignFrames, input.foreign_frames);
  return f;
}

Output report(const State& state, const InverterCommand& command, bool allowed, Faults inputs) {
  Output out;
  if (allowed) {
    out.phase_current = command.phase_current;
    out.wheel = command.wheel;
    out.current_limit = command.limit;
    out.enable = command.enable;
  }
  out.drive_state = state.drive.mode;
  out.ts_request = state.drive.ts_request;
  out.reset_request = state.drive.reset_request;
  out.rtd_sound = state.drive.rtd_sound;
  out.dc_on = state.drive.mode == DriveState::kTsActive || state.drive.mode == DriveState::kReadyToDrive;
  out.faults = state.pedals.latched;
  out.faults.add(state.drive.faults);
  out.faults.add(state.arbitration.faults);
  out.faults.add(inputs);
  out.faults.set(MasterFault::kGateVeto, !allowed);
  out.torque_reason = allowed ? state.arbitration.reason : TorqueReason::kGate;
  out.pedal_request = state.request.pedal;
  VOLTLAP_REQUIRE(out.enable || out.phase_current == Current{});
  VOLTLAP_REQUIRE(!out.enable || out.drive_state == DriveState::kReadyToDrive);
  return out;
}

// What inverters by another maker say is held against the car, and a drive that one drops out of ends.
void watch_inverters(const Config& config, const Input& input, State& state) {
  if (config.inverter_protocol == InverterProtocol::kAmk) {
    watch_amk(config, state.drive.mode, input, state.amk_watch);
    state.drive.inverter_dropped = state.amk_watch.dropped || state.amk_watch.late;
    state.drive.inverters_wait = state.amk_watch.waits;
    state.drive.inverter_disobeys = state.amk_watch.disobeys;
    return;
  }
  watch_inverter(config, input, state.inverter_watch);
  const bool ready = state.drive.mode == DriveState::kReadyToDrive;
  bool stands = false;
  if (config.inverter_protocol == InverterProtocol::kPhaseCurrent) {
    // MST-075: one that is not driven may say nothing of its speed, as in a car that is pushed.
    const bool driven = ready || state.drive.mode == DriveState::kFault;
    stands = speed_stands(input.motor_speed, input.wheel_speed[2], input.wheel_speed[3], input.now,
                          state.speed_watch) && driven;
  } else {
    watch_pm100(ready, input, state.pm100_watch);
    watch_dropping(ready, input, state.inverter_drop);
    state.drive.inverter_dropped = state.inverter_drop.dropped;
  }
  state.drive.inverter_disobeys = stands || state.inverter_watch.disobeys || state.pm100_watch.implausible;
}

InverterCommand command_of(const Config& config, const Input& input, const State& state) {
  const InverterCommand command =
      inverter_command(state.arbitration.current, state.drive.mode, input.inverter_state);
  if (config.inverter_protocol != InverterProtocol::kAmk) return command;
  return wheel_command(config, command, input.inverter_state);
}

Current limit_of(const ArbitrationState& arbitration) {
  return arbitration.current < Current{} ? arbitration.regen_ceiling : arbitration.drive_ceiling;
}

}  // namespace

Output step(const Config& config, const Input& input, State& state) {
  const Duration elapsed = advance(input.now, state);
  pedals_step(config, input, state.pedals);
  watch_inverters(config, input, state);
  drive_state_step(config, input, state.pedals, state.drive);
  request_step(config, input, state.pedals, state.drive.mode, elapsed, state.request);
  arbitration_step(config, input, state.request.current, elapsed, state.arbitration);
  InverterCommand command = command_of(config, input, state);
  command.limit = limit_of(state.arbitration);
  const Output output =
      report(state, command, command_allowed(config, input, command), late_inputs(config, input));
  note_asked(output.phase_current, elapsed, state.inverter_watch);
  note_asked(output, elapsed, state.amk_watch);
  return output;
}

}  // namespace voltlap::master
