// SPDX-License-Identifier: Apache-2.0
#include "io/logs/can/can_line.hpp"

#include <cmath>

#include <CppUTest/TestHarness.h>

using namespace voltlap;
using namespace voltlap::plant;

TEST_GROUP(CanLine) {
  CanLineState state;
  RecordedFrame timed;
  CanLine parse(CanFormat format, const char* line) {
    return parse_can_line(format, line, state, timed);
  }
  void check_kind(CanLine kind, CanFormat format, const char* line) {
    LONGS_EQUAL_TEXT(static_cast<int>(kind), static_cast<int>(parse(format, line)), line);
  }
};

TEST(CanLine, CandumpGivesTimeIdentifierAndBytes) {
  check_kind(CanLine::kFrame, CanFormat::kCandump, "(1436509052.249713) vcan0 044#2A36");
  DOUBLES_EQUAL(1436509052.249713, timed.time_s, 1e-6);
  LONGS_EQUAL(0x44, timed.id);
  LONGS_EQUAL(2, timed.length);
  LONGS_EQUAL(0x36, timed.data[1]);
  check_kind(CanLine::kFrame, CanFormat::kCandump, "(1.0) can0 00000044#");
  CHECK_EQUAL(0x44U | Frame::kExtendedFlag, timed.id);
  LONGS_EQUAL(0, timed.length);
}

TEST(CanLine, CandumpTellsWhatIsNoDataFrame) {
  check_kind(CanLine::kRemote, CanFormat::kCandump, "(1.0) can0 044#R");
  check_kind(CanLine::kError, CanFormat::kCandump, "(1.0) can0 20000004#0000000000000000");
  check_kind(CanLine::kBeyondBus, CanFormat::kCandump, "(1.0) can0 40000000#00");
  for (const char* line : {"(1.0) can0 044#2", "(1.0) can0 044#001122334455667788", "(1.0 can0 044#22",
                           "(1.0) can0", "(x) can0 044#22", "(1.0) can0 0G4#22", "(1.0) can0 044##",
                           "(nan) can0 044#22", "(1e999) can0 044#22", "(1.0) \xff" "can0 044#22", "rubbish"}) {
    check_kind(CanLine::kUnreadable, CanFormat::kCandump, line);
  }
}

TEST(CanLine, AscGivesBothIdentifiersInHexAndDecimal) {
  check_kind(CanLine::kHeader, CanFormat::kAsc, "base hex  timestamps absolute");
  check_kind(CanLine::kFrame, CanFormat::kAsc, "   0.002014 1  1FFFFFF0x       Rx   d 8 01 19 00 07 08 00 00 43");
  CHECK_EQUAL(0x1FFFFFF0U | Frame::kExtendedFlag, timed.id);
  LONGS_EQUAL(0x43, timed.data[7]);
  check_kind(CanLine::kFrame, CanFormat::kAsc, "   0.110420 0  594\tRx   d 2 34 21 ");
  LONGS_EQUAL(0x594, timed.id);
  check_kind(CanLine::kHeader, CanFormat::kAsc, "base dec timestamps relative");
  CHECK(state.differences);
  check_kind(CanLine::kFrame, CanFormat::kAsc, "0.1 1 100 Tx d 2 10 255");
  LONGS_EQUAL(100, timed.id);
  LONGS_EQUAL(255, timed.data[1]);
}

TEST(CanLine, AscTellsHeadersAndEventsFromFrames) {
  for (const char* line : {"date Wed Nov  5 21:37:40 2025", "no internal events logged", "begin triggerblock",
                           "End TriggerBlock", "// version 8.2.1", "", "0.000000 Start of measurement",
                           " 1.0 1  Statistic: D 0 R 0 XD 0 XR 0 E 0 O 0 B 0.00%"}) {
    check_kind(CanLine::kHeader, CanFormat::kAsc, line);
  }
  check_kind(CanLine::kError, CanFormat::kAsc, "1.0 1  ErrorFrame");
  check_kind(CanLine::kRemote, CanFormat::kAsc, "1.0 1  100 Rx r");
  check_kind(CanLine::kError, CanFormat::kAsc, "1.0 CANFD 1 Rx ErrorFrame");
  check_kind(CanLine::kNamed, CanFormat::kAsc, "1.0 1  EngineData Rx d 1 00");
  check_kind(CanLine::kUnreadable, CanFormat::kAsc, "1.0 1  100 Rx d 8 00 11");
}

TEST(CanLine, RawHexHasNoLengthAndTellsExtendedBySize) {
  check_kind(CanLine::kFrame, CanFormat::kRawHex, "0000026Bx000005220108160000000000");
  DOUBLES_EQUAL(0.619, timed.time_s, 1e-12);
  LONGS_EQUAL(0x522, timed.id);
  CHECK_FALSE(timed.has_length);
  check_kind(CanLine::kFrame, CanFormat::kRawHex, "0000028Fx089A0C020000000000000000");
  CHECK_EQUAL(0x089A0C02U | Frame::kExtendedFlag, timed.id);
  check_kind(CanLine::kBeyondBus, CanFormat::kRawHex, "00002C68x20000220070C000000000000");
  check_kind(CanLine::kEmptySlot, CanFormat::kRawHex, "00000000x000000000000000000000000");
  check_kind(CanLine::kUnreadable, CanFormat::kRawHex, "0000026Bx0000052201081600000000");
  check_kind(CanLine::kUnreadable, CanFormat::kRawHex, "0000026Bx00000522010816000000000G");
}

TEST(CanLine, SlcanGivesBothIdentifiersAndItsStamp) {
  check_kind(CanLine::kFrame, CanFormat::kSlcan, "t6B380050000551178EE0071F");
  LONGS_EQUAL(0x6B3, timed.id);
  LONGS_EQUAL(8, timed.length);
  LONGS_EQUAL(0xE0, timed.data[7]);
  DOUBLES_EQUAL(1.823, timed.time_s, 1e-12);
  check_kind(CanLine::kFrame, CanFormat::kSlcan, "T1838F380220160742");
  CHECK_EQUAL(0x1838F380U | Frame::kExtendedFlag, timed.id);
  LONGS_EQUAL(2, timed.length);
  check_kind(CanLine::kUnreadable, CanFormat::kSlcan, "t6B38005");
  check_kind(CanLine::kUnreadable, CanFormat::kSlcan, "t6B390050000551178EE0071F");
  check_kind(CanLine::kRemote, CanFormat::kSlcan, "r12300742");
}

TEST(CanLine, FlexibleFramesHaveUpToSixtyFourBytes) {
  check_kind(CanLine::kFrame, CanFormat::kCandump, "(1.0) can0 044##1AABB");
  LONGS_EQUAL(2, timed.length);
  LONGS_EQUAL(0xBB, timed.data[1]);
  CHECK(timed.flexible);
  check_kind(CanLine::kFrame, CanFormat::kAsc, "1.0 CANFD 1 Rx 100 1 0 8 8 00 11 22 33 44 55 66 77");
  LONGS_EQUAL(0x77, timed.data[7]);
  check_kind(CanLine::kFrame, CanFormat::kAsc,
             "1.0 CANFD  2 Tx   18FF1234x  Motor_Status  1 1 9 12 00 11 22 33 44 55 66 77 88 99 aa bb 130 1 2");
  CHECK_EQUAL(0x18FF1234U | RecordedFrame::kExtendedFlag, timed.id);
  LONGS_EQUAL(12, timed.length);
  LONGS_EQUAL(0xBB, timed.data[11]);
  check_kind(CanLine::kUntimed, CanFormat::kSlcan, "d1239000102030405060708090A0B");
  LONGS_EQUAL(12, timed.length);
  // What a long frame has left is not in the next short one.
  check_kind(CanLine::kFrame, CanFormat::kCandump, "(1.0) can0 044#01");
  for (std::size_t k = 1; k < RecordedFrame::kMostBytes; ++k) LONGS_EQUAL(0, timed.data[k]);
}

TEST(CanLine, TheScreenOfCandumpInAllItsForms) {
  for (const char* line : {" (1700000000.249713)  can0  044   [2]  2A 36", "  can0  044   [2]  2A 36",
                           "(2023-11-14 22:13:20.249713)  can0  044   [2]  2A 36   '*6'",
                           " (1700000000.249713)  can0  RX - -  044   [2]  2A 36", "  can0  044   [2]  36`2A",
                           "\x1b[32m (1700000000.249713)\x1b[0m  can0  044   [2]  2A 36"}) {
    const CanLine kind = parse(CanFormat::kScreen, line);
    CHECK_TEXT(kind == CanLine::kFrame || kind == CanLine::kUntimed, line);
    LONGS_EQUAL_TEXT(0x2A, timed.data[0], line);
    LONGS_EQUAL_TEXT(0x36, timed.data[1], line);
    if (kind == CanLine::kFrame) DOUBLES_EQUAL_TEXT(1700000000.249713, timed.time_s, 1e-6, line);
  }
  check_kind(CanLine::kUntimed, CanFormat::kScreen, "  can0  18FF1234  [12]  00 01 02 03 04 05 06 07 08 09 0A 0B");
  LONGS_EQUAL(12, timed.length);
  check_kind(CanLine::kRemote, CanFormat::kScreen, "  can0  044   [0]  remote request");
  check_kind(CanLine::kError, CanFormat::kScreen, "  can0  20000004   [8]  00 08 00 00 00 00 00 00   ERRORFRAME");
  check_kind(CanLine::kUnreadable, CanFormat::kScreen, "  can0  044   [3]  2A 36");
}

TEST(CanLine, RemoteFramesSayWhatTheyAskFor) {
  struct Case {
    CanFormat format;
    const char* line;
    std::uint32_t id;
    std::uint8_t length;
    bool stamped;
  };
  constexpr std::uint32_t kLong = 0x18FF1234U | RecordedFrame::kExtendedFlag;
  for (const Case& c : {Case{CanFormat::kCandump, "(1.5) can0 044#R", 0x44, 0, true},
                        Case{CanFormat::kCandump, "(1.5) can0 18FF1234#R8", kLong, 8, true},
                        Case{CanFormat::kCandump, "(1.5) can0 044#R9", 0x44, 0, true},
                        Case{CanFormat::kScreen, " (1.5)  can0  044   [3]  remote request", 0x44, 3, true},
                        Case{CanFormat::kScreen, "  can0  044   [3]  remote request", 0x44, 3, false},
                        Case{CanFormat::kAsc, "1.5 1 44 Rx r", 0x44, 0, true},
                        Case{CanFormat::kAsc, "1.5 1 18FF1234x Tx r 8 Length = 0", kLong, 8, true},
                        Case{CanFormat::kSlcan, "r044305DC", 0x44, 3, true},
                        Case{CanFormat::kSlcan, "R18FF123480016E360", kLong, 8, true},
                        Case{CanFormat::kSlcan, "r0448", 0x44, 8, false}}) {
    CHECK_TEXT(parse(c.format, c.line) == CanLine::kRemote, c.line);
    CHECK_EQUAL_TEXT(c.id, timed.id, c.line);
    LONGS_EQUAL_TEXT(c.length, timed.length, c.line);
    CHECK_TEXT(c.stamped ? timed.time_s == 1.5 : std::isnan(timed.time_s), c.line);
  }
  check_kind(CanLine::kUnreadable, CanFormat::kSlcan, "r04");
  check_kind(CanLine::kUnreadable, CanFormat::kSlcan, "r0449");
}

TEST(CanLine, EveryStampOfARelativeFileMovesTheClock) {
  check_kind(CanLine::kHeader, CanFormat::kAsc, "base hex timestamps relative");
  check_kind(CanLine::kFrame, CanFormat::kAsc, "0.5 1 100 Rx d 1 00");
  check_kind(CanLine::kError, CanFormat::kAsc, "0.25 1 ErrorFrame");
  check_kind(CanLine::kHeader, CanFormat::kAsc, "0.25 1 Statistic: D 0 R 0");
  check_kind(CanLine::kFrame, CanFormat::kAsc, "0.5 1 100 Rx d 1 00");
  DOUBLES_EQUAL(1.5, timed.time_s, 0.0);
}

TEST(CanLine, SlcanWithAStampOfThirtyTwoBitsAndWithNone) {
  check_kind(CanLine::kUntimed, CanFormat::kSlcan, "t04412A");
  check_kind(CanLine::kUnreadable, CanFormat::kSlcan, "t04412A0");
  check_kind(CanLine::kFrame, CanFormat::kSlcan, "t04412A000F4240");
  DOUBLES_EQUAL(1.0, timed.time_s, 0.0);
  check_kind(CanLine::kHeader, CanFormat::kSlcan, "z");
}

TEST(CanLine, ATableOfFramesIsReadByTheNamesOfItsColumns) {
  check_kind(CanLine::kHeader, CanFormat::kTable, "Analyser 3000, exported");
  check_kind(CanLine::kHeader, CanFormat::kTable, "Flags\tCh\tT/R\tTime\tCAN ID\tLen\tData\tParser");
  check_kind(CanLine::kFrame, CanFormat::kTable, "1\t0\tRX\t12.5\t0x000001db\t4\t0xee c0 c3 0a \tdefault");
  LONGS_EQUAL(0x1DB, timed.id);
  LONGS_EQUAL(4, timed.length);
  LONGS_EQUAL(0x0A, timed.data[3]);
  DOUBLES_EQUAL(12.5, timed.time_s, 0.0);
  check_kind(CanLine::kUnreadable, CanFormat::kTable, "1\t0\tRX\t12.5\t0x000001db\t4\t0xee c0 c3\tdefault");
  check_kind(CanLine::kUnreadable, CanFormat::kTable, "1\t0\tRX");
  state = {};
  check_kind(CanLine::kHeader, CanFormat::kTable, "Time Stamp,ID,Extended,Dir,Bus,LEN,D1,D2,D3,D4,D5,D6,D7,D8");
  check_kind(CanLine::kFrame, CanFormat::kTable, "2500000,00000123,true,Rx,1,2,0A,FF,,,,,,");
  CHECK_EQUAL(0x123U | RecordedFrame::kExtendedFlag, timed.id);
  LONGS_EQUAL(0xFF, timed.data[1]);
  DOUBLES_EQUAL(2.5, timed.time_s, 1e-12);
  STRCMP_EQUAL("can1", state.buses.at(timed.bus).c_str());
}

TEST(CanLine, BusesAreNumberedInTheOrderInWhichTheySpeak) {
  static_cast<void>(parse(CanFormat::kCandump, "(1.0) can1 044#01"));
  static_cast<void>(parse(CanFormat::kCandump, "(1.0) can0 044#01"));
  LONGS_EQUAL(1, timed.bus);
  static_cast<void>(parse(CanFormat::kCandump, "(1.0) can1 044#01"));
  LONGS_EQUAL(0, timed.bus);
  STRCMP_EQUAL("can0", state.buses.at(1).c_str());
}
