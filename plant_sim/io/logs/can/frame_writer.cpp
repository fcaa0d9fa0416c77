// SPDX-License-Identifier: Apache-2.0
#include "io/logs/can/frame_writer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "core/demand.hpp"

namespace voltlap::plant {
namespace {

void append_bytes(const RecordedFrame& frame, std::string& out) {
  VOLTLAP_DEMAND(frame.length <= RecordedFrame::kMostBytes);
  constexpr char kDigits[] = "0123456789ABCDEF";
  for (std::size_t k = 0; k < frame.length; ++k) {
    out += kDigits[frame.data[k] >> 4];
    out += kDigits[frame.data[k] & 15];
  }
}

}  // namespace

void append_candump(const RecordedFrame& frame, const std::string& bus, std::string& out) {
  const bool extended = (frame.id & RecordedFrame::kExtendedFlag) != 0;
  fmt::format_to(std::back_inserter(out), "({:.6f}) {} {:0{}X}#", frame.time_s, bus,
                 frame.id & ~RecordedFrame::kExtendedFlag, extended ? 8 : 3);
  if (frame.flexible) fmt::format_to(std::back_inserter(out), "#{:X}", frame.flags);
  append_bytes(frame, out);
  out += '\n';
}

void append_slcan(const RecordedFrame& frame, double origin_s, std::string& out) {
  constexpr std::array<std::uint8_t, 16> kLengths{0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64};
  constexpr long long kTurn = 60000;  // ms
  const bool extended = (frame.id & RecordedFrame::kExtendedFlag) != 0;
  const auto code = std::find(kLengths.begin(), kLengths.end(), frame.length) - kLengths.begin();
  VOLTLAP_DEMAND(code < 16);
  const char fast = extended ? 'B' : 'b', slow = extended ? 'D' : 'd';
  const char type = frame.flexible ? ((frame.flags & 1U) != 0 ? fast : slow) : (extended ? 'T' : 't');
  fmt::format_to(std::back_inserter(out), "{}{:0{}X}{:X}", type, frame.id & ~RecordedFrame::kExtendedFlag,
                 extended ? 8 : 3, code);
  append_bytes(frame, out);
  const long long stamp_ms = std::llround(1e3 * (frame.time_s - origin_s));
  fmt::format_to(std::back_inserter(out), "{:04X}\r", ((stamp_ms % kTurn) + kTurn) % kTurn);
}

}  // namespace voltlap::plant
