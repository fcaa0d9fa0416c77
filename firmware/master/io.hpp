// SPDX-License-Identifier: Apache-2.0
// What the master controller is told and what it answers, in unit types. Only the codes of states and faults are those
// of the bus.
#pragma once
#include "base/sample.hpp"
#include "base/units.hpp"
#include "can_dbc/car.hpp"
#include "codec/amk_motors.hpp"

namespace voltlap::master {

using can::BmsState;
using can::DriveState;
using can::InverterState;
using can::MasterFault;
using can::TorqueReason;

using codec::kWheels;

/// Shutdown circuit and buttons of the vehicle.
struct Switches {
  bool shutdown_closed = false;
  bool ts_on_button = false;
  bool rtd_button = false;
  bool reset_button = false;
};

/// One step's measurements. Quality is set by who received them: good = arrived in time, intact, inside its range.
struct Input {
  Instant now{};
  Sample<Potential> apps1, apps2;
  Sample<Pressure> brake_front, brake_rear;
  Sample<Speed> wheel_speed[4];  ///< front left, front right, rear left, rear right
  Sample<MotorSpeed> motor_speed;
  Sample<PackVoltage> dc_link_voltage;
  Sample<InverterState> inverter_state;
  Sample<Current> phase_current;  ///< as the inverter reports it, or by its torque
  Sample<Current> inverter_dc_current;  ///< of an inverter that reports it
  codec::AmkMotors motors;  ///< of a car with one a wheel; what stands above is then of all four
  Sample<PackVoltage> pack_voltage;
  Sample<Current> pack_current;
  Sample<Current> discharge_limit, charge_limit;  ///< DC, both >= 0
  Sample<BmsState> bms_state;
  Sample<Switches> switches;
  Sample<Temperature> motor_temperature, inverter_temperature;
  bool foreign_frames = false;     ///< some message that is received here has a second sender or is replayed
  bool bms_hears_foreign = false;  ///< the BMS says the same of its own
};

/// A set of faults, one bit each, as sent on the bus.
struct Faults {
  std::uint16_t bits = 0;
  void set(MasterFault f, bool on = true) {
    if (on) bits = static_cast<std::uint16_t>(bits | mask(f));
  }
  void add(Faults other) { bits = static_cast<std::uint16_t>(bits | other.bits); }
  [[nodiscard]] bool has(MasterFault f) const { return (bits & mask(f)) != 0; }
  [[nodiscard]] bool any() const { return bits != 0; }

 private:
  static unsigned mask(MasterFault f) { return 1U << static_cast<unsigned>(f); }
};

/// Front left, front right, rear left, rear right.
struct WheelCurrents {
  Current of[kWheels] = {};
  [[nodiscard]] Current sum() const { return of[0] + of[1] + of[2] + of[3]; }
};

struct Output {
  Current phase_current{};  ///< drive positive
  WheelCurrents wheel{};    ///< of it, in a car with a motor a wheel
  bool dc_on = false;       ///< the battery's contactors are closed: such inverters may switch their DC link on
  Current current_limit{};  ///< what it may be now, in the direction of the command; for an inverter that takes one
  bool enable = false;
  DriveState drive_state = DriveState::kInvalid;
  bool ts_request = false;
  bool reset_request = false;
  bool rtd_sound = false;
  Faults faults{};
  TorqueReason torque_reason = TorqueReason::kNone;  ///< what holds the torque below the request
  Ratio pedal_request{};
};

}  // namespace voltlap::master
