// SPDX-License-Identifier: Apache-2.0
#include "base/crc32_table.hpp"

#include "CppUTest/TestHarness.h"
#include "port/image_check.hpp"

using namespace voltlap;

TEST_GROUP(Crc32Table) {
  std::uint8_t bytes[12] = {'1', '2', '3', '4', '5', '6', '7', '8', 0, 0xFF, 0x80, 0x01};
  [[nodiscard]] std::uint32_t by_words(std::size_t count) const {
    std::uint32_t crc = kCrc32Start;
    for (std::size_t i = 0; i < count; i += 4) {
      crc = crc32_word(crc, bytes[i] | std::uint32_t{bytes[i + 1]} << 8 | std::uint32_t{bytes[i + 2]} << 16 |
                                std::uint32_t{bytes[i + 3]} << 24);
    }
    return crc32_finish(crc);
  }
};

TEST(Crc32Table, WordsGiveWhatTheirBytesGive) {
  for (const std::size_t count : {0U, 4U, 8U, 12U}) UNSIGNED_LONGS_EQUAL(crc32(bytes, count), by_words(count));
}

// BMS-091
TEST(Crc32Table, WhateverIsFollowedByItsOwnCrcLeavesTheResidueOfAWholeImage) {
  for (const std::uint8_t first : {std::uint8_t{0x00}, std::uint8_t{0x5A}, std::uint8_t{0xFF}}) {
    bytes[0] = first;
    const std::uint32_t crc = crc32(bytes, 8);
    for (std::size_t i = 0; i < 4; ++i) bytes[8 + i] = static_cast<std::uint8_t>(crc >> (8 * i));
    UNSIGNED_LONGS_EQUAL(port::kImageWhole, by_words(12));
    for (unsigned bit = 0; bit < 96; ++bit) {
      bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ 1U << bit % 8);
      CHECK(by_words(12) != port::kImageWhole);
      bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ 1U << bit % 8);
    }
  }
}
