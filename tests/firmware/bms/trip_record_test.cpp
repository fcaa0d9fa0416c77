// SPDX-License-Identifier: Apache-2.0
#include "bms/trip_record.hpp"

#include <cstring>

#include "can_dbc/car.hpp"

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

// BMS-025: of the version in which bit 0 was the low cell, written as the lowest.
TEST(TripRecord, ARecordOfBeforeTheBitOfIsolationKeepsItsMeaning) {
  const auto bit = [](voltlap::can::BmsFault fault) { return std::uint32_t{1} << static_cast<unsigned>(fault); };
  slots[0] = to_slot({bit(voltlap::can::BmsFault::kCellVoltageLow) | bit(voltlap::can::BmsFault::kForeignFrames), 7});
  LONGS_EQUAL(0x01, slots[0].bytes[1]);
  LONGS_EQUAL(0x01, slots[0].bytes[3]);  // bit 16
  slots[1] = to_slot({bit(voltlap::can::BmsFault::kIsolationFault), 8});
  LONGS_EQUAL(0, slots[1].bytes[1]);
  LONGS_EQUAL(1, read_slots(slots).newest.latched);
}

// BMS-025: what stands in a board's memory.
TEST(TripRecord, TheBytesOfARecordAreWhatTheyWere) {
  const TripSlot slot = to_slot({0x6, 0x1234});
  const unsigned char expected[] = {0xA5, 0x03, 0x00, 0x00, 0x00, 0x34, 0x12};
  static_assert(sizeof(expected) + 1 == kTripRecordBytes);
  MEMCMP_EQUAL(expected, slot.bytes, sizeof(expected));
  unsigned crc = 0xFF;  // SAE J1850, bit by bit
  for (const unsigned byte : expected) {
    crc ^= byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 0x80) != 0 ? (crc << 1 ^ 0x1D) & 0xFF : crc << 1;
  }
  LONGS_EQUAL(crc ^ 0xFF, slot.bytes[kTripRecordBytes - 1]);
  slots[1] = slot;
  LONGS_EQUAL(0x1234, read_slots(slots).newest.writing);
}

// BMS-025
TEST(TripRecord, OfTwoWithOneNumberTheFirstCounts) {
  slots[0] = to_slot({1, 7});
  slots[1] = to_slot({2, 7});
  LONGS_EQUAL(1, read_slots(slots).newest.latched);
  LONGS_EQUAL(1, read_slots(slots).oldest_slot);
}

// BMS-025
TEST(TripRecord, ASlotThatOnlyBeginsBlankIsDamaged) {
  for (const int fill : {0x00, 0xFF}) {
    for (TripSlot& slot : slots) std::memset(slot.bytes, fill, kTripRecordBytes);
    slots[0].bytes[4] = 0x5A;
    CHECK(read_slots(slots).damaged);
  }
}

// BMS-025
TEST(TripRecord, OneBlankSlotBesideADamagedOneHidesNothing) {
  for (const std::size_t damaged : {std::size_t{0}, std::size_t{1}}) {
    for (const int fill : {0x00, 0xFF}) {
      slots[damaged] = to_slot({1, 1});
      slots[damaged].bytes[3] ^= 0x10U;
      std::memset(slots[1 - damaged].bytes, fill, kTripRecordBytes);
      CHECK(read_slots(slots).damaged);
    }
  }
}

// BMS-025
TEST(TripRecord, OnlyZerosAndOnesAreBlank) {
  for (int fill = 0x01; fill < 0xFF; ++fill) {
    for (TripSlot& slot : slots) std::memset(slot.bytes, fill, kTripRecordBytes);
    CHECK(read_slots(slots).damaged);
  }
}

// BMS-025
TEST(TripRecord, TwoDamagedSlotsAreNotTakenForANodeThatHasNeverTripped) {
  slots[0] = slots[1] = to_slot({1, 1});
  for (TripSlot& slot : slots) slot.bytes[3] ^= 0x10U;
  CHECK(read_slots(slots).damaged);
}
