// SPDX-License-Identifier: Apache-2.0
// Vector's ASC of CANalyzer and CANoe, and of the many tools that write it.
#include <algorithm>

#include "io/logs/can/line_words.hpp"

namespace voltlap::plant {
namespace {

CanLine header(std::string_view line, CanLineState& state) {
  const std::string_view first = next_word(line);
  if (first == "base") {
    state.decimal = next_word(line) == "dec";
    state.differences = line.find("relative") != std::string_view::npos;
    return CanLine::kHeader;
  }
  constexpr std::string_view kKnown[] = {"date", "no", "internal", "begin", "Begin", "end", "End", ""};
  const bool known = std::find(std::begin(kKnown), std::end(kKnown), first) != std::end(kKnown);
  return known || first.starts_with("//") || first.starts_with('%') ? CanLine::kHeader : CanLine::kUnreadable;
}

/// An identifier, followed by x where it has 29 bits.
CanLine take_identifier(std::string_view word, const CanLineState& state, RecordedFrame& out) {
  const bool extended = word.ends_with('x') || word.ends_with('X');
  if (extended) word.remove_suffix(1);
  std::uint32_t id = 0;
  if (!whole(word, id, state.decimal ? 10 : 16)) return CanLine::kNamed;
  if (id > (extended ? kLastExtended : kLastStandard)) return CanLine::kBeyondBus;
  out.id = extended ? id | RecordedFrame::kExtendedFlag : id;
  return CanLine::kFrame;
}

CanLine take_bytes(std::string_view line, unsigned length, const CanLineState& state, RecordedFrame& out) {
  out.length = static_cast<std::uint8_t>(length);
  for (unsigned k = 0; k < length; ++k) {
    if (!whole(next_word(line), out.data[k], state.decimal ? 10 : 16)) return CanLine::kUnreadable;
  }
  return CanLine::kFrame;
}

bool is_direction(std::string_view word) {
  return word == "Rx" || word == "Tx" || word == "TxRq" || word == "RX" || word == "TX";
}

/// A frame by its name in a database has its identifier at the end of the line: ID = 258, ID = 419360305x.
std::string_view named_identifier(std::string_view line) {
  constexpr std::string_view kMark = " ID = ";
  const std::size_t at = line.rfind(kMark);
  if (at == std::string_view::npos) return {};
  line.remove_prefix(at + kMark.size());
  return next_word(line);
}

/// 1  1FFFFFF0x       Rx   d 8 01 19 00 07 08 00 00 43
CanLine classic(std::string_view line, const CanLineState& state, RecordedFrame& out) {
  const std::string_view name = next_word(line);
  if (name == "ErrorFrame") return CanLine::kError;
  const std::string_view direction = next_word(line), kind = next_word(line);
  if (!is_direction(direction)) {
    // Statistics, triggers and events of the chip; a frame that has lost its direction is none of them.
    const bool digit = !name.empty() && kHexDigit[static_cast<unsigned char>(name[0])] != kNoDigit;
    const bool event = name.ends_with(':') || !digit;
    return event ? CanLine::kHeader : CanLine::kUnreadable;
  }
  if (direction == "TxRq") return CanLine::kHeader;  // a request to send, not what was on the bus
  CanLine identifier = take_identifier(name, state, out);
  if (const std::string_view id = named_identifier(line); identifier == CanLine::kNamed && !id.empty()) {
    CanLineState decimal;
    decimal.decimal = true;
    identifier = take_identifier(id, decimal, out);
  }
  if (identifier != CanLine::kFrame) return identifier;
  unsigned length = 0;
  if (kind == "r") {  // its length may be left out
    if (whole(next_word(line), length, 16) && length <= 8) out.length = static_cast<std::uint8_t>(length);
    return CanLine::kRemote;
  }
  if (kind != "d" || !whole(next_word(line), length, 16) || length > 15) return CanLine::kUnreadable;
  return take_bytes(line, std::min(length, 8U), state, out);
}

/// CANFD   1 Rx        129  Name 1 0 8  8 01 02 03 04 05 06 07 08 ...: name, BRS, ESI, length code, length, bytes.
CanLine flexible(std::string_view line, const CanLineState& state, RecordedFrame& out, std::string_view direction) {
  if (direction == "ErrorFrame") return CanLine::kError;
  if (!is_direction(direction)) return CanLine::kUnreadable;
  const std::string_view name = next_word(line);
  if (name == "ErrorFrame") return CanLine::kError;
  const CanLine identifier = take_identifier(name, state, out);
  if (identifier != CanLine::kFrame) return identifier;
  std::string_view brs = next_word(line);
  if (brs != "0" && brs != "1") brs = next_word(line);
  const std::string_view esi = next_word(line);
  unsigned code = 0, length = 0;
  if (brs.size() != 1 || esi.size() != 1 || !whole(next_word(line), code, 16)) return CanLine::kUnreadable;
  if (!whole(next_word(line), length) || length > RecordedFrame::kMostBytes) return CanLine::kUnreadable;
  if (length == 0 && code > 0) {
    out.length = static_cast<std::uint8_t>(std::min(code, 8U));
    return CanLine::kRemote;
  }
  out.flags = static_cast<std::uint8_t>((brs == "1" ? 1U : 0U) | (esi == "1" ? 2U : 0U));
  out.flexible = true;  // such a line may hold a classic frame as well, which its data do not show
  return take_bytes(line, length, state, out);
}

}  // namespace

CanLine parse_asc(std::string_view line, CanLineState& state, RecordedFrame& out) {
  std::string_view rest = line;
  double stamp_s = 0.0;
  if (!seconds(next_word(rest), stamp_s)) return header(line, state);
  out.time_s = advance(state, stamp_s);  // of every line: in relative files those that are no frames count too
  std::string_view channel = next_word(rest);
  const bool fd = channel == "CANFD";
  if (fd) channel = next_word(rest);
  unsigned number = 0;
  if (!whole(channel, number)) return CanLine::kHeader;  // events such as "Start of measurement"
  if (!channel_of(channel, state, out.bus)) return CanLine::kUnreadable;
  return fd ? flexible(rest, state, out, next_word(rest)) : classic(rest, state, out);
}

}  // namespace voltlap::plant
