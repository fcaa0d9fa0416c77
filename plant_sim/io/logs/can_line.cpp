// SPDX-License-Identifier: Apache-2.0
#include "io/logs/can_line.hpp"

#include <algorithm>
#include <charconv>

namespace voltlap::plant {
namespace {

constexpr std::uint32_t kLastStandard = 0x7FF, kLastExtended = 0x1FFFFFFF;

template <class Number>
bool whole(std::string_view text, Number& value, int base = 10) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
  return !text.empty() && error == std::errc{} && end == text.data() + text.size();
}

bool seconds(std::string_view text, double& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return !text.empty() && error == std::errc{} && end == text.data() + text.size();
}

/// The next word of a line; empty at its end.
std::string_view word(std::string_view& line) {
  const auto first = line.find_first_not_of(" \t");
  if (first == std::string_view::npos) return line = {};
  line.remove_prefix(first);
  const std::string_view out = line.substr(0, line.find_first_of(" \t"));
  line.remove_prefix(out.size());
  return out;
}

/// Pairs of hexadecimal digits, no more than eight of them.
bool bytes(std::string_view digits, Frame& frame) {
  if (digits.size() % 2 != 0 || digits.size() > 2 * Frame::kMaxBytes) return false;
  frame.dlc = static_cast<std::uint8_t>(digits.size() / 2);
  for (std::size_t k = 0; k < frame.dlc; ++k) {
    if (!whole(digits.substr(2 * k, 2), frame.data[k], 16)) return false;
  }
  return true;
}

bool is_hex(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'F') || (c >= 'a' && c <= 'f');
  });
}

/// (1436509052.249713) vcan0 044#2A36; an interface's name may be followed by R or T.
CanLine candump(std::string_view line, TimedFrame& out) {
  if (line.empty() || line[0] == '#') return CanLine::kHeader;
  const std::string_view stamp = word(line), interface = word(line), frame = word(line);
  if (stamp.size() < 3 || stamp.front() != '(' || stamp.back() != ')' || interface.empty())
    return CanLine::kUnreadable;
  if (!seconds(stamp.substr(1, stamp.size() - 2), out.time_s)) return CanLine::kUnreadable;
  const std::size_t hash = frame.find('#');
  std::uint32_t id = 0;
  if (hash == std::string_view::npos || !whole(frame.substr(0, hash), id, 16)) return CanLine::kUnreadable;
  const std::string_view data = frame.substr(hash + 1);
  if (data.starts_with('#')) return CanLine::kFlexible;
  if (data.starts_with('R')) return CanLine::kRemote;
  const bool extended = hash > 3;
  if (id > kLastExtended) return extended && (id & 0x20000000U) != 0 ? CanLine::kError : CanLine::kBeyondBus;
  if (!extended && id > kLastStandard) return CanLine::kBeyondBus;
  out.frame.id = extended ? id | Frame::kExtendedFlag : id;
  return bytes(data, out.frame) ? CanLine::kFrame : CanLine::kUnreadable;
}

bool asc_header(std::string_view line, CanLineState& state) {
  const std::string_view first = word(line);
  if (first == "base") {
    state.decimal = word(line) == "dec";
    state.relative = line.find("relative") != std::string_view::npos;
    return true;
  }
  const bool known = first == "date" || first == "no" || first == "internal" || first == "begin" ||
                     first == "Begin" || first == "end" || first == "End" || first == "//" || first.empty();
  return known || first.starts_with("//");
}

///    0.002014 1  1FFFFFF0x       Rx   d 8 01 19 00 07 08 00 00 43
CanLine asc(std::string_view line, CanLineState& state, TimedFrame& out) {
  const std::string_view whole_line = line;
  const std::string_view stamp = word(line);
  if (!seconds(stamp, out.time_s)) return asc_header(whole_line, state) ? CanLine::kHeader : CanLine::kUnreadable;
  const std::string_view channel = word(line);
  if (channel == "CANFD") return CanLine::kFlexible;
  unsigned number = 0;
  if (!whole(channel, number)) return CanLine::kHeader;  // events such as "Start of measurement"
  std::string_view name = word(line);
  if (name == "ErrorFrame") return CanLine::kError;
  const bool extended = name.ends_with('x');
  if (extended) name.remove_suffix(1);
  std::uint32_t id = 0;
  if (!whole(name, id, state.decimal ? 10 : 16)) return CanLine::kHeader;  // statistics, triggers
  if (id > (extended ? kLastExtended : kLastStandard)) return CanLine::kBeyondBus;
  const std::string_view direction = word(line), kind = word(line);
  if (direction != "Rx" && direction != "Tx") return CanLine::kUnreadable;
  if (kind == "r") return CanLine::kRemote;
  unsigned length = 0;
  if (kind != "d" || !whole(word(line), length, 16) || length > Frame::kMaxBytes) return CanLine::kUnreadable;
  out.frame.id = extended ? id | Frame::kExtendedFlag : id;
  out.frame.dlc = static_cast<std::uint8_t>(length);
  for (unsigned k = 0; k < length; ++k) {
    if (!whole(word(line), out.frame.data[k], state.decimal ? 10 : 16)) return CanLine::kUnreadable;
  }
  return CanLine::kFrame;
}

/// 0000026Bx000005220108160000000000: identifiers above 0x7FF can only be extended ones.
CanLine raw_hex(std::string_view line, TimedFrame& out) {
  constexpr std::size_t kDigits = 8, kWhole = 2 * kDigits + 1 + 2 * Frame::kMaxBytes;
  if (line.empty()) return CanLine::kHeader;
  std::uint32_t milliseconds = 0, id = 0;
  if (line.size() != kWhole || line[kDigits] != 'x' || !is_hex(line.substr(kDigits + 1)) ||
      !whole(line.substr(0, kDigits), milliseconds, 16) || !whole(line.substr(kDigits + 1, kDigits), id, 16) ||
      !bytes(line.substr(2 * kDigits + 1), out.frame)) {
    return CanLine::kUnreadable;
  }
  out.time_s = 1e-3 * milliseconds;
  out.has_length = false;
  if (id > kLastExtended) return CanLine::kBeyondBus;
  const bool blank = std::all_of(out.frame.data, out.frame.data + Frame::kMaxBytes, [](auto b) { return b == 0; });
  if (id == 0 && blank) return CanLine::kEmptySlot;
  out.frame.id = id > kLastStandard ? id | Frame::kExtendedFlag : id;
  return CanLine::kFrame;
}

/// t6B380050000551178EE0071F: type, identifier, length, data, stamp of 16 bits. T and x: 29-bit identifiers.
CanLine slcan(std::string_view line, TimedFrame& out) {
  if (line.empty()) return CanLine::kHeader;
  const char type = line[0];
  const bool extended = type == 'T' || type == 'x' || type == 'R';
  if (type == 'r' || type == 'R') return CanLine::kRemote;
  if (!extended && type != 't') return CanLine::kUnreadable;
  const std::size_t digits = extended ? 8 : 3;
  std::uint32_t id = 0;
  std::uint16_t stamp = 0;
  if (line.size() < digits + 6 || !whole(line.substr(1, digits), id, 16)) return CanLine::kUnreadable;
  const std::size_t length = static_cast<std::size_t>(line[digits + 1] - '0'), data = digits + 2;
  if (length > Frame::kMaxBytes || line.size() != data + 2 * length + 4) return CanLine::kUnreadable;
  if (!bytes(line.substr(data, 2 * length), out.frame)) return CanLine::kUnreadable;
  if (!whole(line.substr(data + 2 * length), stamp, 16)) return CanLine::kUnreadable;
  if (id > (extended ? kLastExtended : kLastStandard)) return CanLine::kBeyondBus;
  out.time_s = 1e-3 * stamp;
  out.frame.id = extended ? id | Frame::kExtendedFlag : id;
  return CanLine::kFrame;
}

}  // namespace

const char* name_of(CanFormat format) {
  switch (format) {
    case CanFormat::kCandump:
      return "candump";
    case CanFormat::kAsc:
      return "Vector ASC";
    case CanFormat::kRawHex:
      return "raw hex";
    default:
      return "SLCAN";
  }
}

CanLine parse_can_line(CanFormat format, std::string_view line, CanLineState& state, TimedFrame& out) {
  out.has_length = true;
  out.frame = Frame{};
  switch (format) {
    case CanFormat::kCandump:
      return candump(line, out);
    case CanFormat::kAsc:
      return asc(line, state, out);
    case CanFormat::kRawHex:
      return raw_hex(line, out);
    default:
      return slcan(line, out);
  }
}

}  // namespace voltlap::plant
