// SPDX-License-Identifier: Apache-2.0
// What cantools does not do: saturation, refusal, and members that are not ok. The bytes are in the generated suite.
#include "can_dbc/car.hpp"
#include "can_dbc/orion.hpp"

#include "CppUTest/TestHarness.h"

using namespace voltlap;

TEST_GROUP(GeneratedCodec) {
  Frame frame;
};

TEST(GeneratedCodec, ValueBeyondTheRangeIsSaturatedAndAFewLsbInsideIsKept) {
  for (std::int32_t ma : {549'800, 549'900, 550'000}) {
    can::InverterCommand m;
    m.phase_current_ma = ma;
    can::encode(m, frame);
    CHECK(can::decode(frame, m));
    LONGS_EQUAL(ma, m.phase_current_ma);
  }
  for (std::int32_t ma : {550'100, 600'000, 2'147'483'647}) {
    can::InverterCommand m;
    m.phase_current_ma = ma;
    can::encode(m, frame);
    CHECK(can::decode(frame, m));
    LONGS_EQUAL(550'000, m.phase_current_ma);
  }
  can::InverterCommand m;
  m.phase_current_ma = -2'147'483'647 - 1;
  can::encode(m, frame);
  CHECK(can::decode(frame, m));
  LONGS_EQUAL(-550'000, m.phase_current_ma);
}

TEST(GeneratedCodec, ValueThatIsNotOkGoesOutAsTheInvalidCodeAndComesBackAsNoValue) {
  can::PackSensor m;
  m.pack_current_ma = 5'000;
  can::encode(m, frame);
  CHECK(can::decode(frame, m));
  CHECK_FALSE(m.pack_current_ok);
  LONGS_EQUAL(0, m.pack_current_ma);
}

TEST(GeneratedCodec, WrongIdentifierOrLengthLeavesTheMessageAlone) {
  can::PackSensor m;
  m.pack_current_ma = 77;
  CHECK_FALSE(can::decode(Frame{0x0B1, 8, {}}, m));
  CHECK_FALSE(can::decode(Frame{0x0B0, 7, {}}, m));
  CHECK_FALSE(can::decode(Frame{0x0B0 | Frame::kExtendedFlag, 8, {}}, m));
  LONGS_EQUAL(77, m.pack_current_ma);
}

TEST(GeneratedCodec, GroupIsTakenFromTheIdentifierAndEndsWithTheLastOne) {
  can::CellVoltages m;
  for (std::uint32_t g = 0; g < 48; ++g) {
    CHECK(can::decode(Frame{0x200 + g, 8, {}}, m));
    LONGS_EQUAL(g, m.group);
  }
  CHECK_FALSE(can::decode(Frame{0x1FF, 8, {}}, m));
  CHECK_FALSE(can::decode(Frame{0x230, 8, {}}, m));
}

TEST(GeneratedCodec, UnknownCodeOfAnEnumerationReadsAsCodeZero) {
  can::BmsLimits m;
  m.discharge_reason = static_cast<can::LimitReason>(15);
  can::encode(m, frame);
  CHECK(can::decode(frame, m));
  CHECK(m.discharge_reason == can::LimitReason::kNone);
}

TEST(GeneratedCodec, OrionSignsAreTwosComplement) {
  can::LimitBroadcast m;
  m.low_temperature_dc = -200;
  can::encode(m, frame);
  BYTES_EQUAL(0xEC, frame.data[5]);
  CHECK(can::decode(frame, m));
  LONGS_EQUAL(-200, m.low_temperature_dc);
}
