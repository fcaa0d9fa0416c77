// SPDX-License-Identifier: Apache-2.0
// candump of can-utils: its log (-l, -L) and what it writes on the screen.
#include <algorithm>
#include <string>

#include "io/logs/can/line_words.hpp"

namespace voltlap::plant {
namespace {

constexpr std::uint32_t kErrorFlag = 0x20000000U;

/// An identifier of three digits has 11 bits, one of eight 29 or is an error frame's.
CanLine take_identifier(std::string_view digits, RecordedFrame& out) {
  std::uint32_t id = 0;
  if (!hex(digits, id)) return CanLine::kUnreadable;
  const bool extended = digits.size() > 3;
  if (id > kLastExtended) return extended && (id & kErrorFlag) != 0 ? CanLine::kError : CanLine::kBeyondBus;
  if (!extended && id > kLastStandard) return CanLine::kBeyondBus;
  out.id = extended ? id | RecordedFrame::kExtendedFlag : id;
  return CanLine::kFrame;
}

/// Behind the R of a remote frame: how many bytes it asks for, none where nothing is said.
void take_remote_length(std::string_view digits, RecordedFrame& out) {
  const std::uint8_t length = digits.empty() ? kNoDigit : kHexDigit[static_cast<unsigned char>(digits[0])];
  out.length = length <= 8 ? length : 0;
}

/// Nibble pairs, perhaps in groups with dots; `_` begins a length code beyond eight.
bool take_data(std::string_view digits, std::size_t most, RecordedFrame& out) {
  digits = digits.substr(0, digits.find('_'));
  if (digits.find('.') == std::string_view::npos) return hex_bytes(digits, most, out);
  std::string plain(digits);
  std::erase(plain, '.');
  return hex_bytes(plain, most, out);
}

/// The bytes of a line on the screen, up to the column in ASCII; whether they are as many as the line says.
bool take_screen_bytes(std::string_view line, unsigned length, RecordedFrame& out) {
  bool swapped = false;
  for (unsigned k = 0; k < length; ++k) {
    std::string_view byte = next_word(line);
    if (byte.size() > 2 && byte[2] == '`') {  // candump -S: the last byte first, all in one word
      swapped = true;
      line = byte.size() > 3 ? std::string_view(byte.data() + 3, line.data() + line.size() - byte.data() - 3) : line;
      byte = byte.substr(0, 2);
    }
    std::uint32_t value = 0;
    if (byte.size() != 2 || !hex(byte, value)) return false;
    out.data[swapped ? length - 1 - k : k] = static_cast<std::uint8_t>(value);
  }
  return true;
}

std::string without_colours(std::string_view line) {
  std::string out;
  for (std::size_t k = 0; k < line.size(); ++k) {
    if (line[k] == '\x1b') {
      while (k < line.size() && line[k] != 'm') ++k;
    } else {
      out += line[k];
    }
  }
  return out;
}

}  // namespace

CanLine parse_candump(std::string_view line, CanLineState& state, RecordedFrame& out) {
  if (line.empty() || line[0] == '#') return CanLine::kHeader;
  const std::string_view time = next_word(line), interface = next_word(line), frame = next_word(line);
  if (time.size() < 3 || time.front() != '(' || time.back() != ')' || interface.empty()) return CanLine::kUnreadable;
  double stamp_s = 0.0;
  if (!seconds(time.substr(1, time.size() - 2), stamp_s)) return CanLine::kUnreadable;
  const std::size_t hash = frame.find('#');
  if (hash == std::string_view::npos) return CanLine::kUnreadable;
  out.time_s = advance(state, stamp_s);
  const CanLine kind = take_identifier(frame.substr(0, hash), out);
  if (kind != CanLine::kFrame) return kind;
  if (!bus_of(interface, state, out.bus)) return CanLine::kUnreadable;
  std::string_view data = frame.substr(hash + 1);
  if (data.starts_with('R')) {
    take_remote_length(data.substr(1), out);
    return CanLine::kRemote;
  }
  out.flexible = data.starts_with('#');
  if (out.flexible) {
    if (data.size() < 2 || kHexDigit[static_cast<unsigned char>(data[1])] == kNoDigit) return CanLine::kUnreadable;
    out.flags = kHexDigit[static_cast<unsigned char>(data[1])] & 3U;
    data.remove_prefix(2);
  }
  return take_data(data, out.flexible ? RecordedFrame::kMostBytes : 8, out) ? CanLine::kFrame : CanLine::kUnreadable;
}

CanLine parse_screen(std::string_view line, CanLineState& state, RecordedFrame& out) {
  if (line.find('\x1b') != std::string_view::npos) return parse_screen(without_colours(line), state, out);
  const std::size_t first = line.find_first_not_of(" \t");
  if (first == std::string_view::npos) return CanLine::kHeader;
  line.remove_prefix(first);
  const bool stamped = line[0] == '(';
  if (stamped) {
    const std::size_t close = line.find(')');
    double stamp_s = 0.0;
    if (close == std::string_view::npos || !stamp(line.substr(1, close - 1), stamp_s)) return CanLine::kUnreadable;
    out.time_s = advance(state, stamp_s);
    line.remove_prefix(close + 1);
  }
  const std::string_view interface = next_word(line);
  std::string_view id = next_word(line);
  if (id == "RX" || id == "TX") {  // candump -x: direction, then the flags B and E or dashes
    static_cast<void>(next_word(line));
    static_cast<void>(next_word(line));
    id = next_word(line);
  }
  const std::string_view length = next_word(line);
  unsigned bytes = 0;
  if (length.size() < 3 || length.front() != '[' || length.back() != ']' ||
      !whole(length.substr(1, length.size() - 2), bytes) || bytes > RecordedFrame::kMostBytes) {
    return CanLine::kUnreadable;
  }
  const CanLine kind = take_identifier(id, out);
  if (kind != CanLine::kFrame) return kind;
  if (!bus_of(interface, state, out.bus)) return CanLine::kUnreadable;
  if (line.find("remote request") != std::string_view::npos) {
    if (!stamped) out.time_s = kNoTime;
    out.length = static_cast<std::uint8_t>(std::min(bytes, 8U));
    return CanLine::kRemote;
  }
  out.flexible = length.size() == 4;  // two digits
  if (bytes > 8 && !out.flexible) return CanLine::kUnreadable;
  out.length = static_cast<std::uint8_t>(bytes);
  if (!take_screen_bytes(line, bytes, out)) return CanLine::kUnreadable;
  return stamped ? CanLine::kFrame : CanLine::kUntimed;
}

}  // namespace voltlap::plant
