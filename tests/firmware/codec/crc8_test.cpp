// SPDX-License-Identifier: Apache-2.0
#include "codec/crc8.hpp"

#include "CppUTest/TestHarness.h"

using namespace voltlap::codec;

namespace {
std::uint8_t crc_of(const char* text) {
  std::uint8_t crc = kCrc8Start;
  for (; *text != 0; ++text) crc = crc8_step(crc, static_cast<std::uint8_t>(*text));
  return crc8_finish(crc);
}
}  // namespace

TEST_GROUP(Crc8) {};

TEST(Crc8, CheckValueOfSaeJ1850IsRight) { BYTES_EQUAL(0x4B, crc_of("123456789")); }

TEST(Crc8, EveryBitOfTheTableCounts) {
  for (unsigned i = 0; i < 256; ++i) {
    for (unsigned j = i + 1; j < 256; ++j) CHECK(kCrc8Table.of[i] != kCrc8Table.of[j]);
  }
}
