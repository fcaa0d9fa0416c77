// SPDX-License-Identifier: Apache-2.0
#include "io/bus/candump_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

namespace voltlap::plant {

std::string candump_line(std::uint64_t time_ms, const Frame& frame) {
  return candump_line(std::chrono::milliseconds(time_ms), frame, "vcan0");
}

std::string candump_line(std::chrono::microseconds time, const Frame& frame, const std::string& interface) {
  const bool extended = (frame.id & Frame::kExtendedFlag) != 0;
  const std::uint32_t id = frame.id & ~Frame::kExtendedFlag;
  std::string line;
  auto out = std::back_inserter(line);
  fmt::format_to(out, "({}.{:06}) {} ", time.count() / 1'000'000, time.count() % 1'000'000, interface);
  fmt::format_to(out, "{:0{}X}#", id, extended ? 8 : 3);
  constexpr const char* kDigits = "0123456789ABCDEF";
  for (std::size_t i = 0; i < std::min<std::size_t>(frame.dlc, Frame::kMaxBytes); ++i) {
    line += {kDigits[frame.data[i] >> 4], kDigits[frame.data[i] & 15]};
  }
  return line;
}

void CandumpFile::on_frame(std::uint32_t tick, Sender, const Frame& frame) {
  file_.write(candump_line(std::uint64_t{tick} * tick_ms_, frame) + '\n');
}

}  // namespace voltlap::plant
