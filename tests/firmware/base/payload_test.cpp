// SPDX-License-Identifier: Apache-2.0
#include "base/payload.hpp"

#include "CppUTest/TestHarness.h"

using namespace voltlap;

TEST_GROUP(Payload) {};

TEST(Payload, BothByteOrdersComeBack) {
  const std::uint64_t word = 0x0123456789ABCDEFU;
  std::uint8_t data[8];
  payload::store_le(word, data);
  BYTES_EQUAL(0xEF, data[0]);
  CHECK(payload::load_le(data) == word);
  payload::store_be(word, data);
  BYTES_EQUAL(0x01, data[0]);
  CHECK(payload::load_be(data) == word);
}

TEST(Payload, SignIsExtendedFromEveryWidth) {
  for (unsigned length = 2; length <= 31; ++length) {
    const std::int32_t high = (std::int32_t{1} << (length - 1)) - 1;
    for (std::int32_t value : {0, 1, -1, high, -high, -high - 1}) {
      const auto code = static_cast<std::uint32_t>(value) & ((std::uint32_t{1} << length) - 1);
      LONGS_EQUAL(value, payload::sign_extend(code, length));
    }
  }
}

TEST(Payload, RawCodeIsRoundedToNearestAndSaturated) {
  LONGS_EQUAL(1, payload::to_raw(14, 10, 0, 100));
  LONGS_EQUAL(2, payload::to_raw(15, 10, 0, 100));
  LONGS_EQUAL(-2, payload::to_raw(-15, 10, -100, 100));
  LONGS_EQUAL(0, payload::to_raw(-15, 10, 0, 100));
  LONGS_EQUAL(100, payload::to_raw(2'147'483'647, 10, 0, 100));
  LONGS_EQUAL(-100, payload::to_raw(-2'147'483'647 - 1, 1, -100, 100));
}
