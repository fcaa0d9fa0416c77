// SPDX-License-Identifier: Apache-2.0
// Four AMK inverters: their frames to the samples that the drive logic knows, and the currents to their setpoints.
//   T = K I, as a share of the motor's nominal torque, in steps of 0.1 %
//   driving  target velocity: the highest permitted; positive limit T, negative limit 0
//   braking  target velocity 0; positive limit 0, negative limit -T: it cannot push the car backwards
// Their frames have neither CRC nor counter: each is believed by its age. What is told of all four is as old as the
// oldest of them, and the state that of the worst.
#pragma once
#include "base/can_frame.hpp"
#include "codec/amk_frames.hpp"
#include "master/config.hpp"
#include "master/io.hpp"

namespace voltlap::master {

/// What is remembered between their frames. All-zero memory: nothing was received.
struct AmkReading {
  Sample<InverterState> state[kWheels];
  Sample<Temperature> motor[kWheels], inverter[kWheels];
  bool foreign = false;
  Instant foreign_at{};  ///< a frame of one of our own setpoints' identifiers
};

/// What setpoints are made with.
struct AmkScale {
  std::int32_t motor_constant_unm_per_a = 0;
  std::int32_t nominal_torque_mnm = 0;
  MotorSpeed speed_max{};
};

/// Disabled: its DC link is on. Enabled: it obeys setpoints. Off: neither, whatever it waits for.
[[nodiscard]] InverterState amk_state(const codec::AmkActual1& m);

/// One frame that may be believed.
void take_amk(const Frame& frame, AmkReading& reading, Input& in);
/// After the frames of a step.
void settle_amk(AmkReading& reading, Input& in);

/// MST-071, MST-074
[[nodiscard]] codec::AmkSetpoints amk_setpoints(const Output& output, std::size_t wheel, const AmkScale& scale);

}  // namespace voltlap::master
