// SPDX-License-Identifier: Apache-2.0
#include "bms/trip_record.hpp"

#include <cstring>

#include "CppUTest/TestHarness.h"

using namespace voltlap::bms;

TEST_GROUP(TripRecord) {
  TripSlot slots[kTripSlots];
};

// BMS-025
TEST(TripRecord, BlankMemoryIsANodeThatHasNeverTripped) {
  for (const int fill : {0x00, 0xFF}) {
    for (TripSlot& slot : slots) std::memset(slot.bytes, fill, kTripRecordBytes);
    const TripHistory history = read_slots(slots);
    LONGS_EQUAL(0, history.newest.latched);
    CHECK_FALSE(history.damaged);
  }
}

// BMS-025
TEST(TripRecord, TheNewestGoodSlotCountsAlsoAcrossTheWrapOfItsCount) {
  for (const std::uint16_t newest : {std::uint16_t{8}, std::uint16_t{0}, std::uint16_t{32'768}}) {
    slots[0] = to_slot({3, newest});
    slots[1] = to_slot({5, static_cast<std::uint16_t>(newest - 1)});
    LONGS_EQUAL(3, read_slots(slots).newest.latched);
    LONGS_EQUAL(1, read_slots(slots).oldest_slot);
  }
}

// BMS-025
TEST(TripRecord, PowerLostAtAnyByteOfAWritingLeavesTheOldOrTheNewRecord) {
  const TripSlot before = to_slot({0x12345, 41}), after = to_slot({0x80001, 42});
  slots[0] = before;
  for (std::size_t written = 0; written <= kTripRecordBytes; ++written) {
    for (const int erased : {0x00, 0xFF}) {
      std::memset(slots[1].bytes, erased, kTripRecordBytes);
      std::memcpy(slots[1].bytes, after.bytes, written);
      const TripHistory history = read_slots(slots);
      CHECK_FALSE(history.damaged);
      const bool whole = written == kTripRecordBytes || std::memcmp(slots[1].bytes, after.bytes, kTripRecordBytes) == 0;
      LONGS_EQUAL(whole ? 0x80001 : 0x12345, history.newest.latched);
    }
  }
}

// BMS-025
TEST(TripRecord, TwoDamagedSlotsAreNotTakenForANodeThatHasNeverTripped) {
  slots[0] = slots[1] = to_slot({1, 1});
  for (TripSlot& slot : slots) slot.bytes[3] ^= 0x10U;
  CHECK(read_slots(slots).damaged);
}
