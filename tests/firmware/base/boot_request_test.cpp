// SPDX-License-Identifier: Apache-2.0
#include "base/boot_request.hpp"

#include "CppUTest/TestHarness.h"

using namespace voltlap;

TEST_GROUP(BootRequest) {
  std::uint32_t memory[2] = {};
  BootRequest& request = reinterpret_cast<BootRequest&>(memory);
};

TEST(BootRequest, IsTakenOnce) {
  request.ask();
  CHECK(request.take());
  CHECK_FALSE(request.take());
}

// What stands in memory after power-on is near to a request at most by chance.
TEST(BootRequest, WithAnyBitOfItsTwoWordsChangedIsNone) {
  for (unsigned bit = 0; bit < 64; ++bit) {
    request.ask();
    memory[bit / 32] ^= 1U << bit % 32;
    CHECK_FALSE(request.take());
    LONGS_EQUAL(0, memory[0] | memory[1]);
  }
}
