// SPDX-License-Identifier: Apache-2.0
#include "codec/seal.hpp"

#include "can_dbc/car.hpp"
#include "can_dbc/charger.hpp"
#include "can_dbc/orion.hpp"
#include "codec/rx_monitor.hpp"

#include "CppUTest/TestHarness.h"

using namespace voltlap;

namespace {
Frame pack_frame() {
  can::PackSensor m;
  m.pack_current_ma = 123'456;
  m.pack_current_ok = true;
  Frame frame;
  can::encode(m, frame);
  return frame;
}
}  // namespace

TEST_GROUP(Seal) {};

TEST(Seal, SealedFrameIsTrustedAndKeepsItsContents) {
  Frame frame = pack_frame();
  CHECK_FALSE(codec::sealed_ok(frame));
  codec::seal(frame, 9);
  CHECK(codec::sealed_ok(frame));
  LONGS_EQUAL(9, codec::counter_of(frame));
  can::PackSensor m;
  CHECK(can::decode(frame, m));
  LONGS_EQUAL(123'456, m.pack_current_ma);
}

TEST(Seal, EverySingleAndDoubleBitErrorIsFound) {
  Frame frame = pack_frame();
  codec::seal(frame, 5);
  for (unsigned a = 0; a < 64; ++a) {
    for (unsigned b = a; b < 64; ++b) {
      Frame bad = frame;
      bad.data[a / 8] = static_cast<std::uint8_t>(bad.data[a / 8] ^ (1U << (a % 8)));
      if (b != a) bad.data[b / 8] = static_cast<std::uint8_t>(bad.data[b / 8] ^ (1U << (b % 8)));
      CHECK_FALSE(codec::sealed_ok(bad));
    }
  }
}

TEST(Seal, ContentsUnderAnotherIdentifierAreNotTrusted) {
  Frame frame = pack_frame();
  codec::seal(frame, 5);
  frame.id = can::WheelSpeeds::kId;
  CHECK_FALSE(codec::sealed_ok(frame));
}

TEST(Seal, AllZeroFrameIsTrustedUnderNoIdentifierOfTheCar) {
  for (const can::MessageRow& row : can::kMessages) {
    if (row.protection == can::Protection::kCounterCrc) CHECK_FALSE(codec::sealed_ok(Frame{row.id, row.dlc, {}}));
  }
}

TEST(Seal, CounterLeavesTheBitsBesideItAlone) {
  can::InverterStatus m;
  m.state = can::InverterState::kFault;
  Frame frame;
  can::encode(m, frame);
  m.dc_link_voltage_100uv = 6'500'000;  // the byte before it
  m.dc_link_voltage_ok = true;
  can::encode(m, frame);
  for (unsigned counter = 0; counter < 256; ++counter) {
    codec::seal(frame, static_cast<std::uint8_t>(counter));
    LONGS_EQUAL(counter, codec::counter_of(frame));
    can::InverterStatus back;
    CHECK(can::decode(frame, back));
    CHECK(back.state == can::InverterState::kFault);
    LONGS_EQUAL(6'500'000, back.dc_link_voltage_100uv);
  }
}

TEST(Seal, OrionChecksumIsIdPlusEightPlusBytes) {
  Frame frame{can::CellBroadcast::kId, 8, {3, 0x98, 0x58, 0x00, 0xC8, 0x99, 0x10, 0}};
  codec::seal(frame, 0);
  BYTES_EQUAL((0x36 + 8 + 3 + 0x98 + 0x58 + 0xC8 + 0x99 + 0x10) & 0xFF, frame.data[7]);
  CHECK(codec::sealed_ok(frame));
  frame.data[1] = static_cast<std::uint8_t>(frame.data[1] + 1);
  CHECK_FALSE(codec::sealed_ok(frame));
}

TEST(Seal, ForeignFrameStaysAsItIsAndIsNotTrusted) {
  Frame frame{0x7DF, 8, {1, 2, 3, 4, 5, 6, 7, 8}};
  codec::seal(frame, 3);
  BYTES_EQUAL(8, frame.data[7]);
  CHECK_FALSE(codec::sealed_ok(frame));
}

TEST(Seal, SealerCountsEveryMessageByItselfAndWraps) {
  codec::Sealer sealer;
  for (unsigned i = 0; i < 600; ++i) {
    Frame pack = pack_frame();
    sealer.seal(pack);
    LONGS_EQUAL(i % 256, codec::counter_of(pack));
  }
  Frame first;
  can::encode(can::Pedals{}, first);
  sealer.seal(first);
  LONGS_EQUAL(0, codec::counter_of(first));
}

TEST(Seal, AChargersFrameHasNoSealAndIsBelievedByItsAgeAlone) {
  const std::size_t at = codec::find_row(can::kMessages, codec::kMessageCount, can::ChargerStatus::kId);
  CHECK(at != codec::kNoRow);
  const can::MessageRow& row = can::kMessages[at];
  CHECK(row.protection == can::Protection::kAge);
  can::ChargerStatus m;
  m.output_current_ma = 12'300;
  Frame whole;
  can::encode(m, whole);
  const Frame before = whole;
  codec::seal(whole, 77);
  MEMCMP_EQUAL(before.data, whole.data, 8);
  CHECK(codec::sealed_ok(whole));
  Frame other_id = whole;
  other_id.id &= ~Frame::kExtendedFlag;
  CHECK_FALSE(codec::sealed_ok(row, other_id));
  codec::RxRow state;
  const auto at_ms = [](std::uint32_t ms) { return Instant::from_ms(ms); };
  CHECK(codec::judge(row, row.cycle_ms, state, whole, at_ms(0)) == codec::RxVerdict::kResynchronising);
  CHECK(codec::judge(row, row.cycle_ms, state, whole, at_ms(1'000)) == codec::RxVerdict::kAccepted);
  CHECK(codec::fresh(row, state, at_ms(3'999)));
  CHECK_FALSE(codec::fresh(row, state, at_ms(4'000)));
  CHECK(codec::judge(row, row.cycle_ms, state, whole, at_ms(5'000)) == codec::RxVerdict::kResynchronising);
}
