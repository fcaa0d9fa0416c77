// SPDX-License-Identifier: Apache-2.0
// A recording by role through the control units: they run at their own rate in simulated time, on the sensor frames
// that the recording's readings become.
//
// Contacts, DC link and buttons are not in the recording. Before its first moment, and again after a trip, the clock of
// the recording stands still, no current flows, and the units are brought up as a driver would: reset, TS on, ready to
// drive. After a trip that is tried every one to three seconds of the recording until it succeeds: no driver could,
// but the recording drives on, and what the firmware would say then is worth knowing. What flowed meanwhile it does not
// count.
#pragma once
#include "io/bus/in_process_loop.hpp"
#include "replay/role_inputs.hpp"

namespace voltlap::plant {

/// `result` gets everything but names, disagreements and what the reading of the log has found.
void replay_roles(const DriveLog& log, const ReplayCar& car, const PedalSensors& pedals, bool with_model, Ecus& ecus,
                  ReplayResult& result);

}  // namespace voltlap::plant
