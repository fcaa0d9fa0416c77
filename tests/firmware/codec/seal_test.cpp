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

TEST(Seal, AForeignFrameHasNoCounterAndNoSealerGivesItOne) {
  Frame frame{0x7DF, 8, {1, 2, 3, 4, 5, 6, 7, 8}};
  const Frame before = frame;
  codec::Sealer sealer;
  for (int i = 0; i < 3; ++i) sealer.seal(frame);
  MEMCMP_EQUAL(before.data, frame.data, 8);
  LONGS_EQUAL(0, codec::counter_of(frame));
}

TEST(Seal, AMessageWithoutACounterCountsZeroWhateverItsBytesAre) {
  Frame frame{can::CellBroadcast::kId, 8, {9, 9, 9, 9, 9, 9, 9, 9}};
  codec::seal(frame, 3);
  LONGS_EQUAL(0, codec::counter_of(frame));
}

TEST(Seal, AFrameOfAnotherLengthIsNotTrustedThoughItsSealIsRight) {
  Frame frame = pack_frame();
  codec::seal(frame, 9);
  frame.dlc = 7;
  CHECK_FALSE(codec::sealed_ok(frame));
}

TEST(Seal, AMessageWithoutProtectionIsNeverTrustedAndKeepsItsBytes) {
  const can::MessageRow row{0x123, 8, 10, 10, 50, 0, can::Protection::kNone, 6, 7};
  Frame frame{0x123, 8, {1, 2, 3, 4, 5, 6, 7, 8}};
  const Frame before = frame;
  codec::seal(row, frame, 5);
  MEMCMP_EQUAL(before.data, frame.data, 8);
  CHECK_FALSE(codec::sealed_ok(row, frame));
  LONGS_EQUAL(0, codec::counter_of(row, frame));
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
  CHECK_FALSE(codec::fresh(row, state, at_ms(0)));
  CHECK(codec::judge(row, row.cycle_ms, state, whole, at_ms(1'000)) == codec::RxVerdict::kAccepted);
  CHECK(codec::fresh(row, state, at_ms(3'999)));
  CHECK_FALSE(codec::fresh(row, state, at_ms(4'000)));
  CHECK(codec::judge(row, row.cycle_ms, state, whole, at_ms(5'000)) == codec::RxVerdict::kResynchronising);
}

// SAE J1850: x^8 + x^4 + x^3 + x^2 + 1 from 0xFF, inverted; over the identifier, high byte first, and the payload.
TEST(Seal, CrcIsThatOfTheStandardOverIdentifierAndPayload) {
  Frame frame = pack_frame();
  codec::seal(frame, 9);
  const std::uint8_t bytes[] = {static_cast<std::uint8_t>(frame.id >> 8), static_cast<std::uint8_t>(frame.id),
                                frame.data[0], frame.data[1], frame.data[2], frame.data[3], frame.data[4],
                                frame.data[5], frame.data[6]};
  unsigned crc = 0xFF;
  for (const std::uint8_t byte : bytes) {
    crc ^= byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 0x80U) != 0 ? (crc << 1 ^ 0x1DU) & 0xFFU : crc << 1;
  }
  BYTES_EQUAL(crc ^ 0xFFU, frame.data[7]);
}

TEST(Seal, WrongLengthIsNotTrusted) {
  Frame frame = pack_frame();
  codec::seal(frame, 9);
  for (const std::uint8_t dlc : {std::uint8_t{0}, std::uint8_t{7}}) {
    Frame shorter = frame;
    shorter.dlc = dlc;
    CHECK_FALSE(codec::sealed_ok(shorter));
  }
}

TEST(Seal, MessageWithoutProtectionIsLeftAsItIsAndNotTrusted) {
  can::MessageRow row = can::kMessages[codec::find_row(can::kMessages, codec::kMessageCount, can::PackSensor::kId)];
  row.protection = can::Protection::kNone;
  Frame frame = pack_frame();
  const Frame before = frame;
  codec::seal(row, frame, 9);
  CHECK(frame == before);
  CHECK_FALSE(codec::sealed_ok(row, frame));
  codec::seal(frame, 9);  // as if it had one
  CHECK_FALSE(codec::sealed_ok(row, frame));
}

TEST(Seal, OnlyACountedMessageHasACounter) {
  const Frame orion{can::CellBroadcast::kId, 8, {3, 3, 3, 3, 3, 3, 3, 3}};
  LONGS_EQUAL(0, codec::counter_of(orion));
  const Frame foreign{0x7DF, 8, {3, 3, 3, 3, 3, 3, 3, 3}};
  LONGS_EQUAL(0, codec::counter_of(foreign));
  codec::Sealer sealer;
  Frame sealed = foreign;
  sealer.seal(sealed);
  CHECK(sealed == foreign);
}
