// SPDX-License-Identifier: Apache-2.0
#include "port/serial/slcan.hpp"

namespace voltlap::port {
namespace {

constexpr std::uint8_t kReturn = '\r', kNewLine = '\n';
constexpr std::uint32_t kLastStandard = 0x7FF, kLastExtended = 0x1FFF'FFFF;
constexpr std::uint32_t kNoDigit = 16;
constexpr char kDigits[] = "0123456789ABCDEF";

std::uint32_t digit(std::uint8_t byte) {
  if (byte >= '0' && byte <= '9') return byte - std::uint32_t{'0'};
  if (byte >= 'A' && byte <= 'F') return byte - std::uint32_t{'A'} + 10U;
  if (byte >= 'a' && byte <= 'f') return byte - std::uint32_t{'a'} + 10U;
  return kNoDigit;
}

void put(std::uint32_t value, std::size_t digits, std::uint8_t* to) {
  for (std::size_t i = digits; i > 0; --i, value >>= 4) to[i - 1] = static_cast<std::uint8_t>(kDigits[value & 15U]);
}

}  // namespace

bool Slcan::take(std::uint8_t byte, Frame& frame) {
  answer_ = "";
  if (byte == kNewLine) return false;  // of a host that ends its lines with both
  if (byte != kReturn) {
    if (length_ == kLineMax) overlong_ = true;
    if (!overlong_) line_[length_++] = byte;
    return false;
  }
  const bool is_frame = !overlong_ && length_ > 0 && obey(frame);  // an empty line is how a host begins
  if (overlong_) answer_ = "\a";
  if (answer_[0] == '\a') {
    ++refused_;
    lost_ = true;
  }
  length_ = 0;
  overlong_ = false;
  return is_frame;
}

bool Slcan::obey(Frame& frame) {
  if (line_[0] != 't' && line_[0] != 'T') {
    if (!obey_command()) answer_ = "\a";
    return false;
  }
  const bool taken = open_ && !listens_ && take_frame(frame);
  answer_ = !taken ? "\a" : line_[0] == 't' ? "z\r" : "Z\r";
  return taken;
}

bool Slcan::obey_command() {
  const bool alone = length_ == 1;
  answer_ = "\r";
  switch (line_[0]) {
    case 'S':
      return !open_ && length_ == 2 && line_[1] == '6';
    case 'O':
    case 'L':
      if (!alone || open_) return false;
      open_ = true;
      listens_ = line_[0] == 'L';
      return true;
    case 'C':
      if (!alone || !open_) return false;
      open_ = false;
      return true;
    case 'V':
      answer_ = "V0100\r";
      return alone;
    case 'N':
      answer_ = "NVL01\r";
      return alone;
    case 'F':
      answer_ = lost_ ? "F08\r" : "F00\r";  // bit 3: data overrun
      if (alone) lost_ = false;
      return alone;
    case 'Z':
      return length_ == 2 && line_[1] == '0';
    default:
      return false;
  }
}

/// Nothing is written to `frame` unless all of the line is right.
bool Slcan::take_frame(Frame& frame) const {
  const bool extended = line_[0] == 'T';
  const std::size_t digits = extended ? 8 : 3, data = digits + 2;
  std::uint32_t id = 0, dlc = 0;
  if (!number(1, digits, id) || !number(digits + 1, 1, dlc)) return false;
  if (id > (extended ? kLastExtended : kLastStandard) || dlc > Frame::kMaxBytes) return false;
  if (length_ != data + 2 * dlc) return false;
  Frame out;
  out.id = extended ? id | Frame::kExtendedFlag : id;
  out.dlc = static_cast<std::uint8_t>(dlc);
  for (std::size_t i = 0; i < dlc; ++i) {
    std::uint32_t value = 0;
    if (!number(data + 2 * i, 2, value)) return false;
    out.data[i] = static_cast<std::uint8_t>(value);
  }
  frame = out;
  return true;
}

bool Slcan::number(std::size_t first, std::size_t digits, std::uint32_t& value) const {
  if (first + digits > length_) return false;
  value = 0;
  for (std::size_t i = first; i < first + digits; ++i) {
    const std::uint32_t one = digit(line_[i]);
    if (one == kNoDigit) return false;
    value = value << 4 | one;
  }
  return true;
}

std::size_t Slcan::encode(const Frame& frame, std::uint8_t (&line)[kLineMax]) {
  const bool extended = (frame.id & Frame::kExtendedFlag) != 0;
  const std::size_t digits = extended ? 8 : 3;
  const std::size_t bytes = frame.dlc < Frame::kMaxBytes ? frame.dlc : Frame::kMaxBytes;
  line[0] = extended ? 'T' : 't';
  put(frame.id & (extended ? kLastExtended : kLastStandard), digits, line + 1);
  put(static_cast<std::uint32_t>(bytes), 1, line + 1 + digits);
  std::size_t at = digits + 2;
  for (std::size_t i = 0; i < bytes; ++i, at += 2) put(frame.data[i], 2, line + at);
  line[at++] = kReturn;
  return at;
}

}  // namespace voltlap::port
