// SPDX-License-Identifier: Apache-2.0
#include "io/bus/frame_bits.hpp"

#include <random>
#include <vector>

#include <CppUTest/TestHarness.h>

using namespace voltlap;
using namespace voltlap::plant;

namespace {

Frame frame(std::uint32_t id, const std::vector<std::uint8_t>& data) {
  Frame f;
  f.id = id;
  f.dlc = static_cast<std::uint8_t>(data.size());
  for (std::size_t i = 0; i < data.size(); ++i) f.data[i] = data[i];
  return f;
}

/// The frame written out as a row of bits, and nothing clever.
std::vector<bool> bits_before_crc(const Frame& f) {
  std::vector<bool> out;
  const auto append = [&](std::uint32_t value, int width) {
    for (int i = width - 1; i >= 0; --i) out.push_back(((value >> i) & 1U) != 0);
  };
  append(0, 1);
  if ((f.id & Frame::kExtendedFlag) != 0) {
    append(f.id >> 18, 11);
    append(3, 2);
    append(f.id, 18);
    append(0, 3);
  } else {
    append(f.id, 11);
    append(0, 3);
  }
  append(f.dlc, 4);
  for (int i = 0; i < f.dlc; ++i) append(f.data[i], 8);
  return out;
}

std::uint32_t crc_of(const std::vector<bool>& bits) {
  std::uint32_t crc = 0;
  for (const bool bit : bits) {
    const bool next = bit != (((crc >> 14) & 1U) != 0);
    crc = (crc << 1) & 0x7FFF;
    if (next) crc ^= 0x4599;
  }
  return crc;
}

std::uint32_t length_of(const Frame& f) {
  std::vector<bool> bits = bits_before_crc(f);
  const std::uint32_t crc = crc_of(bits);
  for (int i = 14; i >= 0; --i) bits.push_back(((crc >> i) & 1U) != 0);
  std::vector<bool> sent;
  int run = 0;
  for (const bool bit : bits) {
    run = !sent.empty() && sent.back() == bit ? run + 1 : 1;
    sent.push_back(bit);
    if (run == 5) {
      sent.push_back(!bit);
      run = 1;
    }
  }
  return static_cast<std::uint32_t>(sent.size()) + 13;
}

std::uint16_t crc(const Frame& f) { return frame_crc(frame_head(f.id, f.dlc), f); }

}  // namespace

TEST_GROUP(FrameBits){};

// 34 zeros from SOF to the end of the checksum: a stuff bit after each five of them.
TEST(FrameBits, AFrameOfZerosHasAStuffBitAfterEachFive) {
  const Frame zeros = frame(0, {});
  LONGS_EQUAL(0, crc(zeros));
  LONGS_EQUAL(34 + 6 + 13, frame_bits(zeros));
}

// SOF, 11 ones, 7 zeros are sent as 0 11111(0)11111(0)1 00000(1)00.
TEST(FrameBits, OnesInTheIdentifierAreStuffedAndTheStuffBitBeginsTheNextRun) {
  const FrameHead head = frame_head(0x7FF, 0);
  LONGS_EQUAL(19, head.bits);
  LONGS_EQUAL(3, head.stuff_bits);
}

// 0101... has no run of five anywhere: what is stuffed stands before it or in the checksum.
TEST(FrameBits, AlternatingBitsAreNeverStuffed) {
  const FrameHead head = frame_head(0x555, 8);  // 0 101 0101 0101 000 1000
  LONGS_EQUAL(0, head.stuff_bits);
  const Frame f = frame(0x555, {0x55, 0x55, 0x55, 0x55, 0x55, 0x55, 0x55, 0x55});
  LONGS_EQUAL(length_of(f), frame_bits(f));
}

// After five zeros a one is stuffed; four ones that follow make five with it, so that a zero is stuffed, and so on.
TEST(FrameBits, TheWorstPatternIsStuffedEveryFourBits) {
  const Frame f = frame(0x078, {0x3C, 0x3C, 0x3C, 0x3C, 0x3C, 0x3C, 0x3C, 0x3C});
  const Frame shifted = frame(0x078, {0x87, 0x87, 0x87, 0x87, 0x87, 0x87, 0x87, 0x87});
  LONGS_EQUAL(length_of(f), frame_bits(f));
  LONGS_EQUAL(length_of(shifted), frame_bits(shifted));
  CHECK(frame_bits(f) > 111 + 12);
}

TEST(FrameBits, ChecksumsAreThoseOfTheRowOfBits) {
  for (const Frame& f : {frame(0x123, {0xDE, 0xAD, 0xBE, 0xEF}), frame(0x7FF, {}), frame(0x001, {0x80}),
                         frame(0x9ABCDEF0, {1, 2, 3, 4, 5, 6, 7, 8})}) {
    LONGS_EQUAL(crc_of(bits_before_crc(f)), crc(f));
  }
}

TEST(FrameBits, RandomFramesOfEveryLengthHaveTheBitsOfTheirRowAndNoMoreThanTheWorst) {
  std::mt19937 engine(1);
  const auto random = [&] { return static_cast<std::uint32_t>(engine()); };
  std::uint32_t longest = 0;
  for (int i = 0; i < 20000; ++i) {
    Frame f;
    const bool extended = (random() & 1U) != 0;
    f.id = extended ? Frame::kExtendedFlag | (random() & 0x1FFFFFFFU) : random() & 0x7FFU;
    f.dlc = static_cast<std::uint8_t>(random() % 9);
    const std::uint32_t kind = random() % 3;  // any bytes, or few different ones: long runs
    for (std::size_t b = 0; b < f.dlc; ++b) {
      f.data[b] = static_cast<std::uint8_t>(kind == 0   ? random()
                                            : kind == 1 ? 0xFF * (random() & 1U)
                                                        : 0xF0 >> (random() % 5));
    }
    LONGS_EQUAL(length_of(f), frame_bits(f));
    CHECK(frame_bits(f) <= frame_bits_worst(f.dlc, extended));
    if (!extended && f.dlc == 8) longest = std::max(longest, frame_bits(f));
  }
  CHECK(longest > 111 + 10);
}

TEST(FrameBits, TheWorstIsTheFormulaOfTheBusCheck) {
  LONGS_EQUAL(135, frame_bits_worst(8, false));
  LONGS_EQUAL(160, frame_bits_worst(8, true));
  LONGS_EQUAL(55, frame_bits_worst(0, false));
}
