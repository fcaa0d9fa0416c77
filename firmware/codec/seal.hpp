// SPDX-License-Identifier: Apache-2.0
// What makes a frame trustworthy: an 8-bit counter and a CRC-8 over identifier and payload, or the Orion checksum.
#pragma once
#include <cstddef>
#include <cstdint>

#include "base/can_frame.hpp"
#include "can_dbc/tables.hpp"
#include "codec/message_table.hpp"

namespace voltlap::codec {

/// Writes counter and CRC, or the Orion checksum, as the row asks. Call it last: it covers every other bit.
void seal(const can::MessageRow& row, Frame& frame, std::uint8_t counter);
/// The same for any frame of the bus; a frame that is not of this bus stays as it is.
void seal(Frame& frame, std::uint8_t counter);

/// True when identifier and length are right and CRC or checksum match. A row without protection is never
/// trusted; one of kAge, whose maker gives it none, always: who uses it goes by its age.
[[nodiscard]] bool sealed_ok(const can::MessageRow& row, const Frame& frame);
[[nodiscard]] bool sealed_ok(const Frame& frame);

/// The rolling counter of the frame; 0 where the message has none.
[[nodiscard]] std::uint8_t counter_of(const can::MessageRow& row, const Frame& frame);
[[nodiscard]] std::uint8_t counter_of(const Frame& frame);

/// The counters of everything that a node sends, one a message: frame after frame goes out with the next number.
class Sealer {
 public:
  void seal(Frame& frame);

 private:
  std::uint8_t next_[kMessageCount] = {};
};

}  // namespace voltlap::codec
