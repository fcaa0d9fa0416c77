// SPDX-License-Identifier: Apache-2.0
// A Cascadia PM100: its frames to the samples that the drive logic knows, and the command to its frame.
//   T = K I   the logic asks for phase current, the inverter for torque; K the motor's constant
// Its frames have neither CRC nor counter. The fast ones say that it lives; what the slow ones say of its state is good
// while both are known, and is told on with each sign of life.
#pragma once
#include "base/can_frame.hpp"
#include "can_dbc/pm100.hpp"
#include "master/config.hpp"
#include "master/io.hpp"

namespace voltlap::master {

enum class Pm100Fault : std::uint8_t { kNone, kCommandLost, kPost, kRun };

struct Pm100Flags {
  bool enabled = false;
  bool lockout = false;
};

/// What is remembered between its frames. All-zero memory: nothing was received.
struct Pm100Reading {
  Sample<Pm100Flags> flags;
  Sample<Pm100Fault> fault;
  bool alive = false;  ///< a torque frame arrived in this step
  bool foreign = false;
  Instant foreign_at{};  ///< a frame of our own command's identifier
};

/// The frames of pm100.dbc, the command included.
[[nodiscard]] constexpr bool is_pm100(std::uint32_t id) {
  return id >= can::Pm100ModuleTemperatures::kId && id <= can::Pm100Command::kId;
}

[[nodiscard]] Pm100Fault pm100_fault(const can::Pm100Faults& words);
[[nodiscard]] InverterState pm100_state(const Pm100Flags& flags, Pm100Fault fault);

/// One frame that may be believed.
void take_pm100(const Frame& frame, std::int32_t motor_constant_unm_per_a, Pm100Reading& reading, Input& in);
/// After the frames of a step.
void settle_pm100(Pm100Reading& reading, Input& in);

/// MST-064: towards zero in steps of 0.1 Nm; limit at least one step while enabled, for 0 is "as in the EEPROM" there.
[[nodiscard]] can::Pm100Command pm100_command(const Output& output, std::int32_t motor_constant_unm_per_a,
                                              std::uint8_t counter);

}  // namespace voltlap::master
