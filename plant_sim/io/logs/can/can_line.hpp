// SPDX-License-Identifier: Apache-2.0
// One line of a CAN recording in each of the text formats that are read natively:
//   candump -l, -L   (1436509052.249713) vcan0 044#2A36        FD: 044##12A36; may be followed by R or T
//   candump          (1436509052.249713)  vcan0  044   [2]  2A 36      on the screen; with or without a stamp
//   Vector ASC          0.002014 1  1FFFFFF0x       Rx   d 8 01 00 00 05 0C 00 00 63
//   raw hex          0000026Bx000005220108160000000000      milliseconds x identifier data, no length
//   SLCAN            t6B380050000551178EE0071F              with or without a stamp of 16 bits in ms that wraps
//   table of frames  a header that names time, identifier and data; separated by tab, comma or semicolon
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "io/logs/recorded_frame.hpp"

namespace voltlap::plant {

enum class CanFormat { kCandump, kScreen, kAsc, kRawHex, kSlcan, kTable };
[[nodiscard]] const char* name_of(CanFormat format);

/// Columns of a table of frames by number; -1: none.
struct FrameTableHeader {
  char separator = 0;  ///< 0: no header yet
  int time = -1, id = -1, length = -1, data = -1, bus = -1, extended = -1;
  double tick_s = 1.0;  ///< of the time column
  [[nodiscard]] bool known() const { return separator != 0; }
};

/// What the lines before have said.
struct CanLineState {
  bool decimal = false;            ///< ASC: identifiers and bytes are decimal
  bool differences = false;        ///< each stamp counts from the line before: ASC relative, candump -td
  double clock_s = 0.0;            ///< of the last stamped line, frame or not
  FrameTableHeader table;          ///< table of frames: what its columns are
  std::vector<std::string> buses;  ///< names of the interfaces or channels, in the order in which they spoke
};

enum class CanLine {
  kFrame,       ///< with a time
  kUntimed,     ///< a frame without a stamp; its time is left alone
  kHeader,      ///< a comment, a header, an event that is no frame
  kUnreadable,  ///< nothing that the format knows
  kRemote,      ///< with identifier, bus and the length that it asks for; its time is NaN where it has no stamp
  kError,
  kBeyondBus,  ///< an identifier of more than 29 bits
  kNamed,      ///< ASC: a frame by its name in a database, without identifier
  kEmptySlot,  ///< identifier 0 and all bytes 0: a slot of the recorder that was never written
};

/// Takes a line apart; `out.line` is left alone.
[[nodiscard]] CanLine parse_can_line(CanFormat format, std::string_view line, CanLineState& state, RecordedFrame& out);

}  // namespace voltlap::plant
