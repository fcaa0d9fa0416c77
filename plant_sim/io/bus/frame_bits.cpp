// SPDX-License-Identifier: Apache-2.0
#include "io/bus/frame_bits.hpp"

#include <array>

#include "core/demand.hpp"

namespace voltlap::plant {
namespace {

constexpr std::uint32_t kPolynomial = 0x4599U;
constexpr std::uint32_t kCrcMask = (1U << kCrcBits) - 1U;
constexpr std::uint32_t kRunMax = 5;  // equal bits, then a stuff bit

// State of the stuffing: bit 2 is the last bit sent, bits 0..1 the length of its run less one. A run of five is
// ended by its stuff bit at once, so that four lengths are enough. Before the frame the bus is idle: nothing
// counts, and the dominant SOF begins a run whatever was there; a recessive run of one stands for that.
constexpr std::uint8_t kIdle = 0b100;

struct Step {
  std::uint8_t state;
  std::uint8_t stuff_bits;
};

constexpr Step step_bit(std::uint8_t state, bool bit) {
  const bool last = (state & 0b100U) != 0;
  std::uint32_t run = (state & 0b11U) + 1U;
  if (bit != last) return {static_cast<std::uint8_t>(bit ? 0b100U : 0U), 0};
  if (++run < kRunMax) return {static_cast<std::uint8_t>((bit ? 0b100U : 0U) | (run - 1U)), 0};
  return {static_cast<std::uint8_t>(bit ? 0U : 0b100U), 1};
}

constexpr Step step_bits(std::uint8_t state, std::uint32_t value, std::uint32_t count) {
  Step out{state, 0};
  for (std::uint32_t i = count; i-- > 0;) {
    const Step next = step_bit(out.state, ((value >> i) & 1U) != 0);
    out = {next.state, static_cast<std::uint8_t>(out.stuff_bits + next.stuff_bits)};
  }
  return out;
}

constexpr std::uint32_t kStates = 8;

template <std::uint32_t kBits>
constexpr auto stuffing_table() {
  std::array<std::array<Step, 1U << kBits>, kStates> out{};
  for (std::uint8_t state = 0; state < kStates; ++state) {
    for (std::uint32_t value = 0; value < (1U << kBits); ++value) out[state][value] = step_bits(state, value, kBits);
  }
  return out;
}

constexpr auto kStuffing8 = stuffing_table<8>();
constexpr auto kStuffing7 = stuffing_table<7>();
static_assert(kCrcBits == 8 + 7);

constexpr std::uint32_t crc_bit(std::uint32_t crc, bool bit) {
  const bool feedback = (((crc >> (kCrcBits - 1U)) & 1U) != 0) != bit;
  return ((crc << 1U) ^ (feedback ? kPolynomial : 0U)) & kCrcMask;
}

constexpr std::uint32_t crc_bits(std::uint32_t crc, std::uint32_t value, std::uint32_t count) {
  for (std::uint32_t i = count; i-- > 0;) crc = crc_bit(crc, ((value >> i) & 1U) != 0);
  return crc;
}

/// [bytes that follow][value]: the share of one byte in the checksum.
constexpr auto crc_table() {
  std::array<std::array<std::uint16_t, 256>, Frame::kMaxBytes> out{};
  for (std::size_t after = 0; after < Frame::kMaxBytes; ++after) {
    for (std::uint32_t value = 0; value < 256; ++value) {
      std::uint32_t crc = crc_bits(0, value, 8);
      for (std::size_t i = 0; i < after; ++i) crc = crc_bits(crc, 0, 8);
      out[after][value] = static_cast<std::uint16_t>(crc);
    }
  }
  return out;
}

constexpr auto kCrc = crc_table();

/// The bits before the data, first one sent on top.
struct HeadBits {
  std::uint64_t value = 0;
  std::uint32_t count = 0;
  constexpr void append(std::uint32_t bits, std::uint32_t width) {
    value = (value << width) | (bits & ((1U << width) - 1U));
    count += width;
  }
};

constexpr HeadBits head_bits(std::uint32_t id, std::uint8_t dlc) {
  HeadBits out;
  out.append(0, 1);  // SOF
  if ((id & Frame::kExtendedFlag) != 0) {
    out.append(id >> 18U, 11);
    out.append(0b11, 2);  // SRR, IDE
    out.append(id, 18);
    out.append(0b000, 3);  // RTR, r1, r0
  } else {
    out.append(id, 11);
    out.append(0b000, 3);  // RTR, IDE, r0
  }
  out.append(dlc, 4);
  return out;
}

}  // namespace

FrameHead frame_head(std::uint32_t id, std::uint8_t dlc) {
  VOLTLAP_DEMAND(dlc <= Frame::kMaxBytes);
  const HeadBits bits = head_bits(id, dlc);
  FrameHead out;
  out.bits = bits.count;
  out.state = kIdle;
  std::uint32_t crc = 0;
  for (std::uint32_t i = bits.count; i-- > 0;) {
    const bool bit = ((bits.value >> i) & 1U) != 0;
    const Step next = step_bit(out.state, bit);
    out.state = next.state;
    out.stuff_bits += next.stuff_bits;
    crc = crc_bit(crc, bit);
  }
  for (std::uint8_t i = 0; i < dlc; ++i) crc = crc_bits(crc, 0, 8);
  out.crc = static_cast<std::uint16_t>(crc);
  return out;
}

std::uint16_t frame_crc(const FrameHead& head, const Frame& frame) {
  VOLTLAP_DEMAND(frame.dlc <= Frame::kMaxBytes);
  std::uint32_t crc = head.crc;
  for (std::size_t i = 0; i < frame.dlc; ++i) crc ^= kCrc[frame.dlc - 1U - i][frame.data[i]];
  return static_cast<std::uint16_t>(crc);
}

std::uint32_t frame_bits(const FrameHead& head, const Frame& frame) {
  std::uint32_t stuff_bits = head.stuff_bits;
  std::uint8_t state = head.state;
  const auto take = [&](const Step& step) {
    stuff_bits += step.stuff_bits;
    state = step.state;
  };
  for (std::size_t i = 0; i < frame.dlc; ++i) take(kStuffing8[state][frame.data[i]]);
  const std::uint16_t crc = frame_crc(head, frame);
  take(kStuffing8[state][crc >> 7U]);
  take(kStuffing7[state][crc & 0x7FU]);
  return head.bits + 8U * frame.dlc + kCrcBits + stuff_bits + kUnstuffedBits;
}

}  // namespace voltlap::plant
