// SPDX-License-Identifier: Apache-2.0
#include "race/actuators/command_receiver.hpp"

namespace voltlap::plant {

void CommandReceiver::receive(Instant now, FrameView frames, Car& car) {
  for (const Frame& frame : frames) {
    if (monitor_.receive(frame, now) != codec::RxVerdict::kAccepted) continue;
    can::ContactorCommand contactors;
    can::InverterCommand inverter;
    if (decode(frame, contactors)) {
      car.contactors.air_plus.command(contactors.air_plus_close);
      car.contactors.air_minus.command(contactors.air_minus_close);
      car.contactors.precharge.command(contactors.precharge_close);
    } else if (decode(frame, inverter)) {
      car.inverter.command(inverter.phase_current_ma * 1e-3, inverter.enable && inverter.phase_current_ok);
    } else if (!decode(frame, limits_) && !decode(frame, bms_)) {
      static_cast<void>(decode(frame, master_));
    }
  }
  monitor_.expire(now);
  forget_unless_fresh(now, limits_);
  forget_unless_fresh(now, bms_);
  forget_unless_fresh(now, master_);
  if (!monitor_.fresh(can::ContactorCommand::kId, now)) {
    for (Contactor* c : {&car.contactors.air_plus, &car.contactors.air_minus, &car.contactors.precharge})
      c->command(false);
  }
}

}  // namespace voltlap::plant
