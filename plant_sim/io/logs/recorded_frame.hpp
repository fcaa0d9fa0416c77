// SPDX-License-Identifier: Apache-2.0
// A frame as a recording of a CAN bus has it: classic or CAN FD, with its time and the bus it was heard on.
#pragma once
#include <cstddef>
#include <cstdint>

#include "base/can_frame.hpp"

namespace voltlap::plant {

struct RecordedFrame {
  static constexpr std::size_t kMostBytes = 64;
  static constexpr std::uint32_t kExtendedFlag = Frame::kExtendedFlag;  ///< set in `id` for identifiers of 29 bits

  double time_s = 0.0;      ///< of the recording's clock
  std::uint32_t id = 0;     ///< bit 31 set: 29-bit identifier
  std::uint8_t length = 0;  ///< bytes of `data` that count; those behind them are zero
  std::uint8_t bus = 0;     ///< index into the recording's buses
  bool has_length = true;   ///< false: the format gives none, length is 8 and the data may be padded with zeros
  std::uint8_t flags = 0;   ///< of CAN FD: 1 the data were sent faster (BRS), 2 the sender is passive (ESI)
  bool flexible = false;    ///< CAN FD
  bool remote = false;      ///< asks for `length` bytes and has none; only where CanReading asks for such frames
  std::size_t line = 0;     ///< in the file, from 1
  alignas(8) std::uint8_t data[kMostBytes] = {};
};

}  // namespace voltlap::plant
