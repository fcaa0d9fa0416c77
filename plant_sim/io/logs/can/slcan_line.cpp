// SPDX-License-Identifier: Apache-2.0
// What serial adapters and loggers write: SLCAN (LAWICEL and its extensions), and lines of plain hexadecimal digits.
#include <algorithm>

#include "io/logs/can/line_words.hpp"

namespace voltlap::plant {
namespace {

constexpr std::uint8_t kFlexibleLengths[] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64};

/// Nothing, 16 bits in ms, or 32 bits in us.
bool take_stamp(std::string_view digits, bool& stamped, double& time_s) {
  std::uint32_t count = 0;
  stamped = !digits.empty();
  if (!stamped) return true;
  if ((digits.size() != 4 && digits.size() != 8) || !hex(digits, count)) return false;
  time_s = (digits.size() == 4 ? 1e-3 : 1e-6) * count;
  return true;
}

}  // namespace

/// r12380071, R1800012380071F: a remote frame, its length, its stamp.
CanLine take_remote(std::string_view line, CanLineState& state, RecordedFrame& out) {
  const bool extended = line[0] == 'R';
  const std::size_t digits = extended ? 8 : 3, data = digits + 2;
  std::uint32_t id = 0;
  bool stamped = false;
  double time_s = 0.0;
  if (line.size() < data || !hex(line.substr(1, digits), id) || !take_stamp(line.substr(data), stamped, time_s)) {
    return CanLine::kUnreadable;
  }
  if (id > (extended ? kLastExtended : kLastStandard)) return CanLine::kBeyondBus;
  out.id = extended ? id | RecordedFrame::kExtendedFlag : id;
  const std::uint8_t length = kHexDigit[static_cast<unsigned char>(line[digits + 1])];
  if (length > 8 || !bus_of("slcan", state, out.bus)) return CanLine::kUnreadable;
  out.length = length;
  out.time_s = stamped ? advance(state, time_s) : kNoTime;
  return CanLine::kRemote;
}

/// t6B380050000551178EE0071F: type, identifier, length, data, stamp. Small letters 11 bits, T and x 29, d and b FD.
CanLine parse_slcan(std::string_view line, CanLineState& state, RecordedFrame& out) {
  if (line.empty()) return CanLine::kHeader;
  const char type = line[0];
  if (type == 'r' || type == 'R') return take_remote(line, state, out);
  const bool answer = line == "z" || line == "Z" || line == "\a" || type == 'V' || type == 'N' || type == 'F';
  if (answer) return CanLine::kHeader;
  const bool extended = type == 'T' || type == 'x' || type == 'D' || type == 'B';
  out.flags = type == 'b' || type == 'B' ? 1 : 0;  // the data were sent faster
  out.flexible = type == 'd' || type == 'D' || out.flags != 0;
  if (!extended && !out.flexible && type != 't') return CanLine::kUnreadable;
  const std::size_t digits = extended ? 8 : 3, data = digits + 2;
  if (line.size() < data) return CanLine::kUnreadable;
  std::uint32_t id = 0;
  const std::uint8_t code = kHexDigit[static_cast<unsigned char>(line[digits + 1])];
  if (!hex(line.substr(1, digits), id) || code > (out.flexible ? 15 : 8)) return CanLine::kUnreadable;
  const std::size_t length = kFlexibleLengths[code];
  bool stamped = false;
  double time_s = 0.0;
  if (line.size() < data + 2 * length || !hex_bytes(line.substr(data, 2 * length), length, out) ||
      !take_stamp(line.substr(data + 2 * length), stamped, time_s)) {
    return CanLine::kUnreadable;
  }
  if (id > (extended ? kLastExtended : kLastStandard)) return CanLine::kBeyondBus;
  out.id = extended ? id | RecordedFrame::kExtendedFlag : id;
  if (!bus_of("slcan", state, out.bus)) return CanLine::kUnreadable;
  if (stamped) out.time_s = advance(state, time_s);
  return stamped ? CanLine::kFrame : CanLine::kUntimed;
}

/// 0000026Bx000005220108160000000000: identifiers above 0x7FF can only be extended ones.
CanLine parse_raw_hex(std::string_view line, CanLineState& state, RecordedFrame& out) {
  constexpr std::size_t kDigits = 8, kBytes = 8, kWhole = 2 * kDigits + 1 + 2 * kBytes;
  if (line.empty()) return CanLine::kHeader;
  std::uint32_t milliseconds = 0, id = 0;
  if (line.size() != kWhole || line[kDigits] != 'x' || !hex(line.substr(0, kDigits), milliseconds) ||
      !hex(line.substr(kDigits + 1, kDigits), id) || !hex_bytes(line.substr(2 * kDigits + 1), kBytes, out)) {
    return CanLine::kUnreadable;
  }
  out.time_s = advance(state, 1e-3 * milliseconds);
  out.has_length = false;
  if (id > kLastExtended) return CanLine::kBeyondBus;
  const bool blank = std::all_of(out.data, out.data + kBytes, [](auto b) { return b == 0; });
  if (id == 0 && blank) return CanLine::kEmptySlot;
  out.id = id > kLastStandard ? id | RecordedFrame::kExtendedFlag : id;
  return bus_of("bus", state, out.bus) ? CanLine::kFrame : CanLine::kUnreadable;
}

}  // namespace voltlap::plant
