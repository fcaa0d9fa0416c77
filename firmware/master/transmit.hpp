// SPDX-License-Identifier: Apache-2.0
// Decisions to frames: what the master controller sends with every step, sealed, in the order of sending.
#pragma once
#include "base/can_frame.hpp"
#include "codec/seal.hpp"
#include "master/io.hpp"

namespace voltlap::master {

/// The queue must have room for it.
void transmit_command(const Output& output, codec::Sealer& sealer, TxQueue& tx);
void transmit_status(const Output& output, codec::Sealer& sealer, TxQueue& tx);

}  // namespace voltlap::master
