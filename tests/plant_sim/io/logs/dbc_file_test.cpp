// SPDX-License-Identifier: Apache-2.0
#include "io/logs/dbc_file.hpp"

#include <cmath>
#include <cstdlib>
#include <limits>

#include "io/logs/dbc_decoder.hpp"
#include "io/logs/half_float.hpp"
#include "plant_sim/core/scratch.hpp"
#include "plant_sim/io/logs/dbc_cache.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap;
using namespace voltlap::plant;

// A parameter group has no priority and no source, and no destination where it has one (SAE J1939-21, 5.2).
static_assert(parameter_group(0x18FEF1FE) == 0xFEF1 && parameter_group(0x0CFEF117) == 0xFEF1);
static_assert(parameter_group(0x18EA21FE) == 0xEA00 && parameter_group(0x0CEAFF17) == 0xEA00);
static_assert(parameter_group(0x19FEF1FE) != parameter_group(0x18FEF1FE));  // another data page

TEST_GROUP(DbcFile) {
  Scratch scratch;
  TEST_SETUP() { use_dbc_cache_of_this_run(); }

  static RecordedFrame frame_of(std::initializer_list<int> bytes) {
    RecordedFrame out;
    out.id = 1;
    for (const int byte : bytes) out.data[out.length++] = static_cast<std::uint8_t>(byte);
    return out;
  }
  DbcFile file_of(const std::string& text) const { return DbcFile(scratch.write("a.dbc", text)); }
  /// What is said to whom asks for frame 1.
  std::string complaint_of(const std::string& text) const {
    return complaint([&] { file_of(text).check_usable(1); });
  }
};

TEST(DbcFile, BothByteOrdersSignsScalesAndFloatsAreDecoded) {
  struct Case {
    const char* signal;
    int type;
    std::initializer_list<int> bytes;
    double value;
  };
  const Case cases[] = {{"0|16@1+ (1,0)", 0, {0x12, 0x34, 0, 0, 0, 0, 0, 0}, 0x3412},
                        {"7|16@0+ (1,0)", 0, {0x12, 0x34, 0, 0, 0, 0, 0, 0}, 0x1234},
                        {"7|16@0- (1,0)", 0, {0xFF, 0xFF, 0, 0, 0, 0, 0, 0}, -1.0},
                        {"7|11@0- (0.5,0)", 0, {0xEC, 0x00, 0, 0, 0, 0, 0, 0}, -80.0},
                        {"63|8@0+ (1.0,1721)", 0, {0, 0, 0, 0, 0, 0, 0, 5}, 1726.0},
                        {"11|2@1+ (1,0)", 0, {0x00, 0x18, 0, 0, 0, 0, 0, 0}, 3.0},
                        {"15|56@0+ (1,0)", 0, {0, 1, 2, 3, 4, 5, 6, 7}, 0x01020304050607p0},
                        {"0|16@1+ (1E-2,-1.0E2)", 0, {0xD4, 0x30, 0, 0, 0, 0, 0, 0}, 25.0},
                        {"0|64@1- (1,0)", 0, {0xFE, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF}, -2.0},
                        {"0|64@1+ (1,0)", 0, {0, 0, 0, 0, 0, 0, 0, 0x80}, 0x1p63},
                        {"0|32@1- (2,0)", 1, {0x00, 0x00, 0xC0, 0x3F, 0, 0, 0, 0}, 3.0},
                        {"7|64@0- (1,0)", 2, {0x40, 0x0C, 0, 0, 0, 0, 0, 0}, 3.5},
                        {"0|16@1- (1,0)", 1, {0x00, 0xC2, 0, 0, 0, 0, 0, 0}, -3.0}};
  std::string text, types;
  int id = 0;
  for (const Case& each : cases) {
    text += "BO_ " + std::to_string(++id) + " F: 8 X\n SG_ S : " + each.signal + " [0|0] \"\" X\n";
    types += "SIG_VALTYPE_ " + std::to_string(id) + " S : " + std::to_string(each.type) + ";\n";
  }
  const DbcFile dbc = file_of(text + types);
  LONGS_EQUAL(std::size(cases), dbc.messages().size());
  for (std::size_t k = 0; k < std::size(cases); ++k) {
    const DbcMessage& message = dbc.messages()[k];
    const auto raw = raw_value(message, message.signals.front(), frame_of(cases[k].bytes));
    DOUBLES_EQUAL_TEXT(cases[k].value, message.signals.front().value(raw.value()), 1e-12, cases[k].signal);
  }
}

TEST(DbcFile, WhatHidesStatementsFromALineReaderDoesNotHideThem) {
  // Escaped quotes, tabs, CR LF, several signals in a line, comments over several lines, unused signals.
  const DbcFile dbc = file_of(
      "VERSION \"\"\r\nBO_ 3221225472 VECTOR__INDEPENDENT_SIG_MSG: 0 Vector__XXX\r\n"
      " SG_ Old : 0|16@1+ (1,0) [0|0] \"\" X\r\n\r\nBO_\t1\tF: 8 X\r\n"
      "\tSG_\tA : 0|32@1- (1,0) [0|0] \"\" X SG_ B : 32|32@1- (1,0) [0|0] \"\" X\r\n"
      "CM_ SG_ 1 A \"bar 1\\\" wide\";\r\nCM_ BO_ 1 \"first\r\nBO_ 2 F: 8 X\r\n SG_ broken\r\nlast\";\r\n"
      "SIG_VALTYPE_ 1 A : 1;\r\nSIG_VALTYPE_ 1 B : 1;\r\nBA_DEF_ SG_  \"SystemSignalLongSymbol\" STRING ;\r\n"
      "BA_ \"SystemSignalLongSymbol\" SG_ 1 B \"A_Long_Name\";\r\nVAL_ 3221225472 Old 1 \"one\" ;\r\n");
  LONGS_EQUAL(1, dbc.messages().size());
  const DbcMessage& message = dbc.messages()[0];
  LONGS_EQUAL(2, message.signals.size());
  LONGS_EQUAL(5, message.line);
  CHECK(message.find("A")->kind == DbcSignal::Kind::kFloat);
  CHECK(message.find("A_Long_Name")->kind == DbcSignal::Kind::kFloat);
  LONGS_EQUAL(6, message.find("A_Long_Name")->line);
}

TEST(DbcFile, MultiplexedSignalIsThereInItsCasesOnlyAndMultiplexersNest) {
  const DbcFile dbc = file_of(
      "BO_ 1 F: 8 X\n SG_ Outer M : 0|8@1- (1,0) [0|0] \"\" X\n SG_ Inner m1M : 8|8@1+ (1,0) [0|0] \"\" X\n"
      " SG_ A m0 : 16|8@1+ (1,0) [0|0] \"\" X\n SG_ B m7 : 16|8@1+ (1,0) [0|0] \"\" X\n"
      "SG_MUL_VAL_ 1 Inner Outer 1-3, 255-255;\nSG_MUL_VAL_ 1 A Outer 0-0;\nSG_MUL_VAL_ 1 B Inner 7-9, 20-20;\n");
  const DbcMessage& message = dbc.messages()[0];
  const auto there = [&](const char* name, std::initializer_list<int> bytes) {
    return raw_value(message, *message.find(name), frame_of(bytes)).has_value();
  };
  CHECK(there("A", {0, 7, 42}));
  CHECK_FALSE(there("B", {0, 7, 42}));
  CHECK(there("Inner", {3, 7, 42}));
  CHECK(there("B", {3, 9, 42}));
  CHECK(there("B", {255, 20, 42}));  // the signed multiplexer by its bits
  CHECK_FALSE(there("B", {3, 10, 42}));
  CHECK_FALSE(there("B", {4, 7, 42}));
  CHECK_FALSE(there("B", {3, 7}));  // the frame ends before it
  CHECK_FALSE(there("Inner", {3}));
}

TEST(DbcFile, WhatTheFileSaysIsNoValueIsAnInvalidCode) {
  const DbcFile dbc = file_of(
      "BO_ 1 F: 8 X\n SG_ U : 0|16@1+ (0.1,0) [0|0] \"\" X\n SG_ I : 16|16@1- (1,0) [0|0] \"\" X\n"
      " SG_ C : 32|8@1+ (1,0) [0|0] \"\" X\n SG_ N : 40|8@1+ (1,0) [0|0] \"\" X\n"
      "VAL_ 1 U 65535 \"SNA\" 65534 \"Sensor_Error\" 0 \"NoError\" ;\nVAL_ 1 I -32768 \"not available\" ;\n"
      "CM_ SG_ 1 C \"255 = 100 %, 0xFE = invalid\";\n");
  const DbcMessage& message = dbc.messages()[0];
  CHECK(message.find("U")->is_invalid_code(0xFFFF));
  CHECK(message.find("U")->is_invalid_code(0xFFFE));
  CHECK_FALSE(message.find("U")->is_invalid_code(0));
  CHECK(message.find("I")->is_invalid_code(0x8000));
  CHECK_FALSE(message.find("I")->is_invalid_code(0x7FFF));
  CHECK(message.find("C")->is_invalid_code(0xFE));
  CHECK_FALSE(message.find("C")->is_invalid_code(0xFF));
  CHECK_FALSE(message.find("N")->is_invalid_code(0xFF));  // full throttle, for instance
}

TEST(DbcFile, EndsOfTheRawValuesBeyondTheRangeAreKnown) {
  const DbcFile dbc = file_of(
      "BO_ 1 F: 8 X\n SG_ Throttle : 0|8@1+ (0.392157,0) [0|100] \"%\" X\n SG_ V : 8|16@1+ (0.1,0) [0|600] \"V\" X\n"
      " SG_ I : 24|12@1- (1,0) [-2048|1000] \"A\" X\n SG_ Full : 36|8@1+ (1,0) [0|255] \"\" X\n"
      " SG_ None : 44|8@1+ (1,0) [0|0] \"\" X\n SG_ Short : 52|4@1+ (1,0) [0|9] \"\" X\n");
  const DbcMessage& message = dbc.messages()[0];
  CHECK_FALSE(message.find("Throttle")->is_end_beyond_range(0xFF));  // 100.00004 % is 100 %
  CHECK(message.find("V")->is_end_beyond_range(0xFFFF));
  CHECK_FALSE(message.find("V")->is_end_beyond_range(0xFFFE));
  CHECK(message.find("I")->is_end_beyond_range(0x7FF));
  CHECK_FALSE(message.find("I")->is_end_beyond_range(0x800));
  for (const char* name : {"Full", "None"}) CHECK_FALSE(message.find(name)->is_end_beyond_range(0xFF));
  CHECK_FALSE(message.find("Short")->is_end_beyond_range(0xF));
}

TEST(DbcFile, WhatCannotBeReadExactlyIsRefusedByFileAndLineToWhoAsksForIt) {
  const auto with = [](const char* signals) { return std::string("BO_ 1 F: 8 X\n") + signals; };
  STRCMP_CONTAINS("a.dbc:2: found frame 0x1 for the second time", complaint_of("BO_ 1 F: 8 X\nBO_ 1 G: 8 X\n").c_str());
  STRCMP_CONTAINS("a.dbc:3: found signal Blank for the second time",
                  complaint_of(with(" SG_ Blank : 0|8@1+ (1,0) [0|0] \"\" X\n SG_ Blank : 8|8@1+ (1,0) [0|0] \"\" X\n"))
                      .c_str());
  STRCMP_CONTAINS("a.dbc:2: found signal S that ends in byte 8",
                  complaint_of(with(" SG_ S : 60|8@1+ (1,0) [0|0] \"\" X\n")).c_str());
  STRCMP_CONTAINS("without its own", complaint_of(with(" SG_ S m1M : 0|8@1+ (1,0) [0|0] \"\" X\n")).c_str());
  STRCMP_CONTAINS("a.dbc:1: found what cantools cannot read",
                  complaint_of(with(" SG_ S : x|8@1+ (1,0) [0|0] \"\" X\n")).c_str());
}

TEST(DbcFile, RefusedFrameHurtsNoOther) {
  const DbcFile dbc = file_of(
      "BO_ 1 F: 8 X\n SG_ S : x|8@1+ (1,0) [0|0] \"\" X\nBO_ 2 G: 8 X\n SG_ T : 0|8@1+ (1,0) [0|0] \"\" X\n"
      "CM_ \"never closed;\nBO_ 3 H: 8 X\n SG_ U : 0|8@1+ (1,0) [0|0] \"\" X\n");
  LONGS_EQUAL(2, dbc.messages().size());
  CHECK(dbc.find(2) != nullptr);
  CHECK(dbc.find(3) != nullptr);
  CHECK(dbc.find(1) == nullptr);
  STRCMP_EQUAL("no error", complaint([&] { dbc.check_usable(2); }).c_str());
  LONGS_EQUAL(1, dbc.refused().size());
}

TEST(DbcFile, FileThatIsNoDbcIsRefused) {
  STRCMP_CONTAINS("no frame (BO_)", complaint_of("VERSION \"\"\n").c_str());
  STRCMP_CONTAINS("an empty file", complaint_of("").c_str());
  STRCMP_CONTAINS("a binary file", complaint_of(std::string("BO_ 1\0 F", 8)).c_str());
  STRCMP_CONTAINS("cannot be opened", complaint([&] { DbcFile(scratch.file("none.dbc")); }).c_str());
  STRCMP_CONTAINS("a folder", complaint([&] { DbcFile(scratch.file("")); }).c_str());
}

TEST(DbcFile, AllSignalsOfAFrameAtOnceAreThoseOneByOne) {
  const DbcFile dbc = file_of(
      "BO_ 1 F: 16 X\n SG_ Mux M : 0|8@1+ (1,0) [0|0] \"\" X\n SG_ A m0 : 13|64@1- (0.5,1) [0|0] \"\" X\n"
      " SG_ B m1 : 9|64@0+ (1,0) [0|0] \"\" X\n SG_ C : 120|8@1+ (1,-40) [0|0] \"\" X\n");
  const DbcDecoder decoder(dbc);
  const CompiledMessage* message = decoder.find(1);
  CHECK(message != nullptr);
  CHECK(decoder.find(2) == nullptr);
  CHECK(decoder.find(1 | RecordedFrame::kExtendedFlag) == nullptr);
  std::uint32_t state = 12345;
  for (int round = 0; round < 1000; ++round) {
    RecordedFrame frame;
    frame.length = static_cast<std::uint8_t>(round % 17);
    for (int k = 0; k < frame.length; ++k) {
      state = state * 1664525 + 1013904223;
      frame.data[k] = static_cast<std::uint8_t>(k == 0 ? state >> 30 : state >> 24);
    }
    double values[4] = {};
    std::uint64_t present[1] = {};
    message->decode_all(frame, values, present);
    for (std::size_t k = 0; k < 4; ++k) {
      const DbcSignal& signal = dbc.messages()[0].signals[k];
      const auto raw = raw_value(dbc.messages()[0], signal, frame);
      CHECK_EQUAL(raw.has_value(), (present[0] >> k & 1) != 0);
      if (raw) CHECK_EQUAL(signal.value(*raw), values[k]);
    }
  }
}

TEST(DbcFile, HalfFloatsAreThoseOfTheStandard) {
  DOUBLES_EQUAL(1.0, half_float(0x3C00), 0.0);
  DOUBLES_EQUAL(-2.0, half_float(0xC000), 0.0);
  DOUBLES_EQUAL(65504.0, half_float(0x7BFF), 0.0);
  DOUBLES_EQUAL(0x1p-24, half_float(0x0001), 0.0);
  CHECK(std::isinf(half_float(0xFC00)));
  CHECK(std::isnan(half_float(0x7C01)));
}
