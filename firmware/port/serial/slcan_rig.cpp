// SPDX-License-Identifier: Apache-2.0
#include "port/serial/slcan_rig.hpp"

#include "base/require.hpp"
#include "can_dbc/lockstep.hpp"

namespace voltlap::port {

std::size_t SlcanRig::read(std::uint8_t* bytes, std::size_t capacity) {
  VOLTLAP_REQUIRE(capacity >= kFrameBytes);
  Frame frame;
  std::uint32_t polls = 0;
  for (bool idle = false; !poll(frame, idle);) {
    polls = idle ? polls + 1 : 0;
    if (stepped_ || polls < polls_per_hello_) continue;
    if (slcan_.is_open()) send(hello_, hello_count_);
    polls = 0;
  }
  if (frame.id == can::Sync::kId) stepped_ = true;
  frame_to_bytes(frame, bytes);
  return kFrameBytes;
}

bool SlcanRig::write(const std::uint8_t* bytes, std::size_t count) {
  VOLTLAP_REQUIRE(count % kFrameBytes == 0);
  Frame lost;
  bool idle = false;
  while (!slcan_.is_open()) static_cast<void>(poll(lost, idle));
  if (!greeted_) {
    VOLTLAP_REQUIRE(count <= kHelloMax);
    for (std::size_t i = 0; i < count; ++i) hello_[i] = bytes[i];
    hello_count_ = count;
    greeted_ = true;
  }
  send(bytes, count);
  return true;
}

bool SlcanRig::poll(Frame& frame, bool& idle) {
  std::uint8_t byte = 0;
  idle = !serial_.read(byte);
  if (idle) return false;
  const bool whole = slcan_.take(byte, frame);
  say(slcan_.answer());
  return whole;
}

void SlcanRig::say(const char* text) {
  for (; *text != '\0'; ++text) serial_.write(static_cast<std::uint8_t>(*text));
}

void SlcanRig::send(const std::uint8_t* bytes, std::size_t count) {
  for (std::size_t at = 0; at < count; at += kFrameBytes) {
    Frame frame;
    VOLTLAP_REQUIRE(frame_from_bytes(bytes + at, frame));
    std::uint8_t line[Slcan::kLineMax];
    const std::size_t length = Slcan::encode(frame, line);
    for (std::size_t i = 0; i < length; ++i) serial_.write(line[i]);
  }
}

}  // namespace voltlap::port
