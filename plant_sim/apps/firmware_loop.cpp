// SPDX-License-Identifier: Apache-2.0
#include "apps/firmware_loop.hpp"

#include "apps/firmware_config.hpp"

namespace voltlap::plant {

FirmwareLoop::FirmwareLoop(const VehicleParameters& car) : FirmwareLoop(bms_config(car), master_config(car)) {}

void FirmwareLoop::bms(Instant now, FrameView rx, TxQueue& tx) { bms_.tick(now, rx, tx); }

void FirmwareLoop::master(Instant now, FrameView rx, TxQueue& tx) { master_.tick(now, rx, tx); }

}  // namespace voltlap::plant
