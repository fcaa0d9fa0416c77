// SPDX-License-Identifier: Apache-2.0
#include "io/logs/can/can_line.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>

#include "io/logs/can/line_words.hpp"

namespace voltlap::plant {
namespace {

constexpr std::array<double, 10> kTenToThe{1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9};
constexpr std::uint64_t kExact = std::uint64_t{1} << 53;  // whole numbers up to it are doubles

/// 2023-11-14 22:13:20.249713, taken as UTC: only differences of a recording's times count.
bool date_and_time(std::string_view text, double& time_s) {
  if (text.size() < 19 || text[4] != '-' || text[7] != '-' || text[13] != ':' || text[16] != ':') return false;
  int year = 0, hour = 0, minute = 0;
  unsigned month = 0, day = 0;
  double second = 0.0;
  if (!whole(text.substr(0, 4), year) || !whole(text.substr(5, 2), month) || !whole(text.substr(8, 2), day) ||
      !whole(text.substr(11, 2), hour) || !whole(text.substr(14, 2), minute) || !seconds(text.substr(17), second)) {
    return false;
  }
  const std::chrono::year_month_day date{std::chrono::year(year), std::chrono::month(month), std::chrono::day(day)};
  if (!date.ok()) return false;
  const auto days = std::chrono::sys_days(date).time_since_epoch().count();
  time_s = 86400.0 * static_cast<double>(days) + 3600.0 * hour + 60.0 * minute + second;
  return true;
}

}  // namespace

bool seconds(std::string_view text, double& value) {
  // Up to 2^53 the quotient of two whole numbers is the nearest double, as from_chars gives it, in a fifth of its time.
  std::uint64_t digits = 0;
  std::size_t k = 0, point = text.size();
  for (; k < text.size(); ++k) {
    const unsigned digit = static_cast<unsigned>(text[k] - '0');
    if (digit <= 9 && digits < kExact / 16) {
      digits = 10 * digits + digit;
    } else if (text[k] == '.' && point == text.size()) {
      point = k;
    } else {
      break;
    }
  }
  const std::size_t decimals = point == text.size() ? 0 : text.size() - point - 1;
  if (k == text.size() && k > (point < k ? 1U : 0U) && decimals < kTenToThe.size()) {
    value = static_cast<double>(digits) / kTenToThe[decimals];
    return true;
  }
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return !text.empty() && error == std::errc{} && end == text.data() + text.size() && std::isfinite(value);
}

bool stamp(std::string_view text, double& time_s) {
  return seconds(text, time_s) || date_and_time(text, time_s);
}

bool hex_bytes(std::string_view digits, std::size_t most, RecordedFrame& frame) {
  if (digits.size() % 2 != 0 || digits.size() > 2 * most) return false;
  frame.length = static_cast<std::uint8_t>(digits.size() / 2);
  unsigned wrong = 0;
  for (std::size_t k = 0; k < frame.length; ++k) {
    const std::uint8_t high = kHexDigit[static_cast<unsigned char>(digits[2 * k])],
                       low = kHexDigit[static_cast<unsigned char>(digits[2 * k + 1])];
    wrong |= high | low;
    frame.data[k] = static_cast<std::uint8_t>(high << 4 | low);
  }
  return wrong < 16;
}

bool bus_of(std::string_view name, CanLineState& state, std::uint8_t& bus) {
  constexpr std::size_t kMost = 255;
  for (std::size_t k = 0; k < state.buses.size(); ++k) {
    if (state.buses[k] != name) continue;
    bus = static_cast<std::uint8_t>(k);
    return true;
  }
  const auto printed = [](char c) { return c > ' ' && c <= '~'; };  // other bytes are damage, and no name
  if (state.buses.size() >= kMost || !std::all_of(name.begin(), name.end(), printed)) return false;
  bus = static_cast<std::uint8_t>(state.buses.size());
  state.buses.emplace_back(name);
  return true;
}

bool channel_of(std::string_view number, CanLineState& state, std::uint8_t& bus) {
  const bool digits = !number.empty() && number.size() <= 4 &&
                      std::all_of(number.begin(), number.end(), [](char c) { return c >= '0' && c <= '9'; });
  if (!digits) return bus_of(number, state, bus);
  std::array<char, 8> name{'c', 'a', 'n'};
  std::copy(number.begin(), number.end(), name.begin() + 3);
  return bus_of({name.data(), 3 + number.size()}, state, bus);
}

const char* name_of(CanFormat format) {
  switch (format) {
    case CanFormat::kCandump:
      return "candump";
    case CanFormat::kScreen:
      return "candump on the screen";
    case CanFormat::kAsc:
      return "Vector ASC";
    case CanFormat::kRawHex:
      return "raw hex";
    case CanFormat::kTable:
      return "table of frames";
    default:
      return "SLCAN";
  }
}

CanLine parse_can_line(CanFormat format, std::string_view line, CanLineState& state, RecordedFrame& out) {
  out.has_length = true;
  out.flexible = false;
  out.remote = false;
  out.flags = 0;
  out.bus = 0;
  // Only what a frame before may have left.
  std::memset(out.data, 0, out.length > 8 ? RecordedFrame::kMostBytes : 8);
  out.length = 0;
  switch (format) {
    case CanFormat::kCandump:
      return parse_candump(line, state, out);
    case CanFormat::kScreen:
      return parse_screen(line, state, out);
    case CanFormat::kAsc:
      return parse_asc(line, state, out);
    case CanFormat::kRawHex:
      return parse_raw_hex(line, state, out);
    case CanFormat::kTable:
      return parse_frame_table(line, state, out);
    default:
      return parse_slcan(line, state, out);
  }
}

}  // namespace voltlap::plant
