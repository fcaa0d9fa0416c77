// SPDX-License-Identifier: Apache-2.0
// One line of a CAN recording in each of the formats of can_recording.hpp.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "base/can_frame.hpp"

namespace voltlap::plant {

enum class CanFormat { kCandump, kAsc, kRawHex, kSlcan };
[[nodiscard]] const char* name_of(CanFormat format);

struct TimedFrame {
  double time_s = 0.0;     ///< as recorded
  bool has_length = true;  ///< false: the format gives none, dlc is 8 and the data may be padded with zeros
  std::size_t line = 0;
  Frame frame;
};

/// What header lines have said so far.
struct CanLineState {
  bool decimal = false;   ///< ASC: identifiers and bytes are decimal
  bool relative = false;  ///< ASC: each stamp counts from the line before
};

enum class CanLine {
  kFrame,
  kHeader,      ///< a comment, a header, an event that is no frame
  kUnreadable,  ///< nothing that the format knows
  kFlexible,    ///< CAN FD
  kRemote,
  kError,
  kBeyondBus,  ///< an identifier of more than 29 bits
  kEmptySlot,  ///< identifier 0 and all bytes 0: a slot of the recorder that was never written
};

/// Takes a line apart; `out.line` is left alone.
[[nodiscard]] CanLine parse_can_line(CanFormat format, std::string_view line, CanLineState& state, TimedFrame& out);

}  // namespace voltlap::plant
