// SPDX-License-Identifier: Apache-2.0
// Decisions to frames: what the BMS sends with every step, sealed, in the order of sending.
#pragma once
#include "base/can_frame.hpp"
#include "bms/state.hpp"
#include "codec/seal.hpp"

namespace voltlap::bms {

/// Contactor command, limits, status, Orion pack and cell every step; the Orion limits when they are due. The queue
/// must have room for all of them.
void transmit(const Output& output, codec::Sealer& sealer, TxQueue& tx);

}  // namespace voltlap::bms
