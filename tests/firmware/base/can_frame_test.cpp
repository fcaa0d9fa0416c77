// SPDX-License-Identifier: Apache-2.0
#include "base/can_frame.hpp"

#include "CppUTest/TestHarness.h"

using namespace voltlap;

TEST_GROUP(TxQueue) {};

TEST(TxQueue, KeepsItsOrderAndRefusesWhatDoesNotFit) {
  TxQueue queue;
  for (std::uint32_t i = 0; i < TxQueue::kCapacity; ++i) CHECK(queue.push(Frame{i, 8, {}}));
  CHECK_FALSE(queue.push(Frame{99, 8, {}}));
  LONGS_EQUAL(TxQueue::kCapacity, queue.size());
  std::uint32_t expected = 0;
  for (const Frame& frame : queue) LONGS_EQUAL(expected++, frame.id);
  queue.clear();
  LONGS_EQUAL(0, queue.size());
}

TEST_GROUP(Frame) {};

TEST(Frame, IsEqualWhereIdentifierLengthAndEveryByteAre) {
  const Frame frame{0x1C0, 8, {1, 2, 3, 4, 5, 6, 7, 8}};
  Frame other = frame;
  CHECK(frame == other);
  for (std::uint8_t& byte : other.data) {
    ++byte;
    CHECK(frame != other);
    --byte;
  }
  other.id = 0x1C1;
  CHECK(frame != other);
  other = frame;
  other.dlc = 7;
  CHECK(frame != other);
}
