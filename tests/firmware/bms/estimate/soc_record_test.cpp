// SPDX-License-Identifier: Apache-2.0
#include "bms/estimate/soc_record.hpp"

#include <cstring>

#include "base/crc32.hpp"
#include "estimate/filter_bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;

namespace {

SocRecord a_record(std::int16_t soc, std::uint16_t writing) {
  SocRecord record;
  record.cells = 24;
  record.writing = writing;
  record.pieces = 47;
  for (std::size_t i = 0; i < 24; ++i) {
    record.cell[i] = {static_cast<std::int16_t>(soc + static_cast<int>(i)), -7, 250, 9'000, -600};
  }
  return record;
}

}  // namespace

TEST_GROUP(SocRecord) {
  SocSlot slots[kSocSlots];
  SocRecord newest;
  std::size_t oldest = 9;
  void read() { read_slots(slots, newest, oldest); }
};

// BMS-083
TEST(SocRecord, BlankMemoryKnowsNothing) {
  for (const int fill : {0x00, 0xFF}) {
    for (SocSlot& slot : slots) std::memset(slot.bytes, fill, kSocRecordBytes);
    read();
    LONGS_EQUAL(0, newest.cells);
    LONGS_EQUAL(0, oldest);
  }
}

// BMS-083
TEST(SocRecord, TheNewestGoodSlotCountsAlsoAcrossTheWrapOfItsCount) {
  for (const std::uint16_t writing : {std::uint16_t{8}, std::uint16_t{0}, std::uint16_t{32'768}}) {
    to_slot(a_record(1'000, writing), slots[0]);
    to_slot(a_record(2'000, static_cast<std::uint16_t>(writing - 1)), slots[1]);
    read();
    LONGS_EQUAL(1'000, newest.cell[0].soc);
    LONGS_EQUAL(47, newest.pieces);
    LONGS_EQUAL(1, oldest);
    slots[0].bytes[700] ^= 0x40U;
    read();
    LONGS_EQUAL(2'000, newest.cell[0].soc);
    LONGS_EQUAL(0, oldest);
  }
}

// BMS-083
TEST(SocRecord, PowerLostAtAnyByteOfAWritingLeavesTheOldOrTheNewRecord) {
  SocSlot after;
  to_slot(a_record(1'000, 41), slots[0]);
  to_slot(a_record(2'000, 42), after);
  for (std::size_t written = 0; written <= kSocRecordBytes; ++written) {
    for (const int erased : {0x00, 0xFF}) {
      std::memset(slots[1].bytes, erased, kSocRecordBytes);
      std::memcpy(slots[1].bytes, after.bytes, written);
      const bool whole = std::memcmp(slots[1].bytes, after.bytes, kSocRecordBytes) == 0;
      read();
      LONGS_EQUAL(24, newest.cells);
      LONGS_EQUAL(whole ? 2'023 : 1'023, newest.cell[23].soc);
      LONGS_EQUAL(-600, newest.cell[23].fade);
    }
  }
}

// BMS-083
TEST(SocRecord, WhatIsKeptIsRestoredWithinItsSteps) {
  const Config config = filtered_config();
  SocEstimate state;
  restore(config, a_record(12'345, 1), state);
  CHECK(state.filter.restored);
  state.valid = true;
  SocRecord again;
  keep(config, state, again);
  for (std::size_t i = 0; i < 24; ++i) {
    LONGS_EQUAL(12'345 + static_cast<int>(i), again.cell[i].soc);
    LONGS_EQUAL(-7, again.cell[i].v1);
    LONGS_EQUAL(250, again.cell[i].v2);
    LONGS_EQUAL(9'000, again.cell[i].scale);
    LONGS_EQUAL(-600, again.cell[i].fade);
  }
}

// BMS-083
TEST(SocRecord, ARecordOfAnotherPackIsNone) {
  const Config config = filtered_config();
  SocEstimate state;
  SocRecord record = a_record(12'345, 1);
  record.cells = 22;
  restore(config, record, state);
  CHECK_FALSE(state.filter.restored);
}

// BMS-083
TEST(SocRecord, ValuesThatNoFilterHasAreHeldWithinItsBounds) {
  const Config config = filtered_config();
  SocEstimate state;
  SocRecord record = a_record(0, 1);
  record.cell[0] = {32'767, 32'767, -32'768, 65'535, 32'767};
  restore(config, record, state);
  const CellFilter& filter = state.filter.cell[0].filter;
  LONGS_EQUAL(kSocHigh, filter.s);
  LONGS_EQUAL(kBranchMost, filter.v1);
  LONGS_EQUAL(-kBranchMost, filter.v2);
  LONGS_EQUAL(kScaleHigh, filter.rho);
  LONGS_EQUAL(kFadeHigh, filter.fade);
}

// BMS-048
TEST(SocRecord, TheChargeThatItSaysIsTheMeanOfItsCells) {
  CHECK(recorded_soc(SocRecord{}) == Soc{});
  SocRecord record = a_record(8'192, 1);
  record.cell[0].soc = 8'192 - 2'400;
  LONGS_EQUAL(494'568, recorded_soc(record).raw());  // 8'192 + (276 - 2'400) / 24 = 8'103 of 2^14
  record.cell[1].soc = static_cast<std::int16_t>(record.cell[1].soc + 11);  // 23 / 24 are nothing
  LONGS_EQUAL(494'568, recorded_soc(record).raw());
}

TEST(SocRecord, AnEstimateThatIsNotValidKeepsNothing) {
  SocRecord record = a_record(0, 1);
  keep(filtered_config(), SocEstimate{}, record);
  LONGS_EQUAL(0, record.cells);
}

namespace {

/// As something else has written it, with the CRC that belongs to it.
void reseal(SocSlot& slot) {
  const std::uint32_t crc = crc32(slot.bytes, kSocRecordBytes - 4);
  for (std::size_t i = 0; i < 4; ++i) {
    slot.bytes[kSocRecordBytes - 4 + i] = static_cast<std::uint8_t>(crc >> (8 * i));
  }
}

}  // namespace

// BMS-083: every cell that a pack may have, with numbers that are all different.
TEST(SocRecord, EveryNumberOfEveryCellComesBackFromItsSlot) {
  SocRecord record;
  record.cells = kMaxCells;
  record.writing = 7;
  record.pieces = 1'234;
  for (std::size_t i = 0; i < kMaxCells; ++i) {
    const int k = static_cast<int>(i);
    record.cell[i] = {static_cast<std::int16_t>(300 * k - 20'000), static_cast<std::int16_t>(11 - 7 * k),
                      static_cast<std::int16_t>(13 * k), static_cast<std::uint16_t>(40'000 + k),
                      static_cast<std::int16_t>(-17 * k)};
  }
  to_slot(record, slots[0]);
  LONGS_EQUAL(0x5D, slots[0].bytes[0]);  // the layout's mark: what an older image has written is read
  read();
  LONGS_EQUAL(kMaxCells, newest.cells);
  LONGS_EQUAL(7, newest.writing);
  LONGS_EQUAL(1'234, newest.pieces);
  for (std::size_t i = 0; i < kMaxCells; ++i) {
    LONGS_EQUAL(record.cell[i].soc, newest.cell[i].soc);
    LONGS_EQUAL(record.cell[i].v1, newest.cell[i].v1);
    LONGS_EQUAL(record.cell[i].v2, newest.cell[i].v2);
    LONGS_EQUAL(record.cell[i].scale, newest.cell[i].scale);
    LONGS_EQUAL(record.cell[i].fade, newest.cell[i].fade);
  }
}

// BMS-083
TEST(SocRecord, ASlotOfAnotherLayoutOrOfTooManyCellsIsNone) {
  for (const std::size_t byte : {std::size_t{0}, std::size_t{1}}) {
    to_slot(a_record(1'000, 1), slots[0]);
    slots[0].bytes[byte] = byte == 0 ? 0x5E : kMaxCells + 1;
    reseal(slots[0]);
    read();
    LONGS_EQUAL(0, newest.cells);
  }
  slots[0].bytes[1] = kMaxCells;
  reseal(slots[0]);
  read();
  LONGS_EQUAL(kMaxCells, newest.cells);
}

// BMS-083
TEST(SocRecord, WhatWasThereBeforeIsGoneFromASlotAndFromARecord) {
  std::memset(slots[0].bytes, 0xFF, kSocRecordBytes);
  to_slot(a_record(1'000, 1), slots[0]);
  LONGS_EQUAL(0, slots[0].bytes[6]);
  LONGS_EQUAL(0, slots[0].bytes[7]);
  slots[0].bytes[700] ^= 1U;
  newest.cells = 24;
  read();
  LONGS_EQUAL(0, newest.cells);
}

// BMS-083
TEST(SocRecord, TwoSlotsAreReadAndOfTwoThatAreAsNewTheFirst) {
  SocSlot three[3];
  for (std::uint16_t k = 0; k < 3; ++k) to_slot(a_record(static_cast<std::int16_t>(1'000 * k), k), three[k]);
  read_slots(reinterpret_cast<const SocSlot(&)[kSocSlots]>(three), newest, oldest);
  LONGS_EQUAL(1'000, newest.cell[0].soc);
  to_slot(a_record(3'000, 9), slots[0]);
  to_slot(a_record(4'000, 9), slots[1]);
  read();
  LONGS_EQUAL(3'000, newest.cell[0].soc);
  LONGS_EQUAL(1, oldest);
}

// BMS-083
TEST(SocRecord, ACountKeepsItsChargeAloneInEveryCell) {
  const Config config = pack_config();
  SocEstimate state;
  state.valid = true;
  state.value = Soc::from_raw(250'000);
  SocRecord record = a_record(9, 1);
  record.cell[24].soc = 77;  // of no cell of the pack
  keep(config, state, record);
  LONGS_EQUAL(24, record.cells);
  for (std::size_t i = 0; i < 24; ++i) {
    LONGS_EQUAL(1 << 12, record.cell[i].soc);
    CHECK(record.cell[i].v1 == 0 && record.cell[i].v2 == 0 && record.cell[i].fade == 0);
    LONGS_EQUAL(1 << 13, record.cell[i].scale);
  }
  LONGS_EQUAL(77, record.cell[24].soc);
}

// BMS-083
TEST(SocRecord, CellsBeyondThePackAreNotRestoredAndARecordOfNoneRestoresNothing) {
  const Config config = filtered_config();
  SocEstimate state;
  SocRecord record = a_record(1'000, 1);
  record.cell[24].soc = 1'000;
  const std::int32_t before = state.filter.cell[24].filter.s;
  restore(config, record, state);
  LONGS_EQUAL(before, state.filter.cell[24].filter.s);
  SocEstimate nothing;
  record.cells = 0;
  restore(config, record, nothing);
  CHECK_FALSE(nothing.filter.restored);
}
