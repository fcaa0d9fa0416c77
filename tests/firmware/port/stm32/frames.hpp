// SPDX-License-Identifier: Apache-2.0
// Frames for the tests of the CAN drivers.
#pragma once
#include <CppUTest/TestHarness.h>

#include "base/can_frame.hpp"

namespace voltlap::port::stm32::test {

/// Whose every byte tells it from others.
inline Frame frame_of(std::uint32_t id, std::uint8_t mark = 0, std::uint8_t dlc = 8) {
  Frame f;
  f.id = id;
  f.dlc = dlc;
  for (std::uint8_t i = 0; i < dlc; ++i) f.data[i] = static_cast<std::uint8_t>(mark * 8 + i + 1);
  return f;
}

inline void check_same(const Frame& expected, const Frame& got) {
  UNSIGNED_LONGS_EQUAL(expected.id, got.id);
  UNSIGNED_LONGS_EQUAL(expected.dlc, got.dlc);
  MEMCMP_EQUAL(expected.data, got.data, sizeof expected.data);
}

template <class Ids>
TxQueue queue_of(const Ids& ids) {
  TxQueue out;
  std::uint8_t mark = 0;
  for (const std::uint32_t id : ids) CHECK(out.push(frame_of(id, mark++)));
  return out;
}

}  // namespace voltlap::port::stm32::test
