// SPDX-License-Identifier: Apache-2.0
// A message of the DBC becomes a sealed frame in the queue.
#pragma once
#include "base/can_frame.hpp"
#include "base/require.hpp"
#include "codec/seal.hpp"

namespace voltlap::codec {

/// The queue must have room: a node sends a known number of frames a step.
template <class Message>
void send(const Message& message, Sealer& sealer, TxQueue& tx) {
  Frame frame;
  encode(message, frame);
  sealer.seal(frame);
  const bool room = tx.push(frame);
  VOLTLAP_REQUIRE(room);
}

}  // namespace voltlap::codec
