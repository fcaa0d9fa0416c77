// SPDX-License-Identifier: Apache-2.0
// What the text formats of CAN recordings are made of: words, numbers, hexadecimal bytes, names of buses.
#pragma once
#include <array>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string_view>

#include "io/logs/can/can_line.hpp"

namespace voltlap::plant {

inline constexpr double kNoTime = std::numeric_limits<double>::quiet_NaN();
inline constexpr std::uint32_t kLastStandard = 0x7FF, kLastExtended = 0x1FFFFFFF;

template <class Number>
[[nodiscard]] bool whole(std::string_view text, Number& value, int base = 10) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
  return !text.empty() && error == std::errc{} && end == text.data() + text.size();
}

/// The next word of a line; empty at its end.
[[nodiscard]] inline std::string_view next_word(std::string_view& line) {
  std::size_t first = 0;
  while (first < line.size() && (line[first] == ' ' || line[first] == '\t')) ++first;
  std::size_t end = first;
  while (end < line.size() && line[end] != ' ' && line[end] != '\t') ++end;
  const std::string_view out = line.substr(first, end - first);
  line.remove_prefix(end);
  return out;
}

inline constexpr std::uint8_t kNoDigit = 0xFF;
inline constexpr std::array<std::uint8_t, 256> kHexDigit = [] {
  std::array<std::uint8_t, 256> out{};
  for (auto& value : out) value = kNoDigit;
  for (unsigned k = 0; k < 10; ++k) out['0' + k] = static_cast<std::uint8_t>(k);
  for (unsigned k = 0; k < 6; ++k) out['A' + k] = out['a' + k] = static_cast<std::uint8_t>(10 + k);
  return out;
}();

/// A hexadecimal number of at most eight digits.
[[nodiscard]] inline bool hex(std::string_view text, std::uint32_t& value) {
  if (text.empty() || text.size() > 8) return false;
  value = 0;
  for (const char c : text) {
    const std::uint8_t digit = kHexDigit[static_cast<unsigned char>(c)];
    if (digit == kNoDigit) return false;
    value = value << 4 | digit;
  }
  return true;
}

/// Pairs of hexadecimal digits, no more than `most` of them.
[[nodiscard]] bool hex_bytes(std::string_view digits, std::size_t most, RecordedFrame& frame);

/// Seconds with a fraction, to the nearest double; nothing but a finite number.
[[nodiscard]] bool seconds(std::string_view text, double& value);

/// What stands between the brackets of a candump stamp: seconds, or date and time of day.
[[nodiscard]] bool stamp(std::string_view text, double& time_s);

/// Number of a bus by its name; a new one is added. False for what is no name, and when there are more than 255.
[[nodiscard]] bool bus_of(std::string_view name, CanLineState& state, std::uint8_t& bus);

/// The same for a channel that has a number only: can1 for 1, as in every other format.
[[nodiscard]] bool channel_of(std::string_view number, CanLineState& state, std::uint8_t& bus);

/// Time of a stamp that was read: as it is, or after the line before.
[[nodiscard]] inline double advance(CanLineState& state, double stamp_s) {
  return state.clock_s = state.differences ? state.clock_s + stamp_s : stamp_s;
}

[[nodiscard]] CanLine parse_candump(std::string_view line, CanLineState& state, RecordedFrame& out);
[[nodiscard]] CanLine parse_screen(std::string_view line, CanLineState& state, RecordedFrame& out);
[[nodiscard]] CanLine parse_asc(std::string_view line, CanLineState& state, RecordedFrame& out);
[[nodiscard]] CanLine parse_raw_hex(std::string_view line, CanLineState& state, RecordedFrame& out);
[[nodiscard]] CanLine parse_frame_table(std::string_view line, CanLineState& state, RecordedFrame& out);
[[nodiscard]] CanLine parse_slcan(std::string_view line, CanLineState& state, RecordedFrame& out);

}  // namespace voltlap::plant
