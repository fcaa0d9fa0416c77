// SPDX-License-Identifier: Apache-2.0
#include "io/logs/dbc_file.hpp"

#include <cmath>

#include "plant_sim/core/scratch.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap;
using namespace voltlap::plant;

TEST_GROUP(DbcFile) {
  Scratch scratch;
  std::string complaint_of(const char* text) {
    const std::string path = scratch.write("a.dbc", text);
    return complaint([&] { DbcFile ignored(path); });
  }
  double decode(const char* signal, std::initializer_list<int> bytes) {
    const DbcFile dbc(scratch.write("a.dbc", std::string("BO_ 1 F: 8 X\n SG_ S : ") + signal + " [0|0] \"\" X\n"));
    Frame frame{1, 8, {}};
    std::size_t k = 0;
    for (const int byte : bytes) frame.data[k++] = static_cast<std::uint8_t>(byte);
    const DbcMessage& message = dbc.messages().front();
    return message.signals.front().value(raw_value(message, message.signals.front(), frame).value());
  }
};

TEST(DbcFile, BothByteOrdersSignsAndScalesAreDecoded) {
  DOUBLES_EQUAL(0x3412, decode("0|16@1+ (1,0)", {0x12, 0x34}), 0.0);
  DOUBLES_EQUAL(0x1234, decode("7|16@0+ (1,0)", {0x12, 0x34}), 0.0);
  DOUBLES_EQUAL(-1.0, decode("7|16@0- (1,0)", {0xFF, 0xFF}), 0.0);
  DOUBLES_EQUAL(-80.0, decode("7|11@0- (0.5,0)", {0xEC, 0x00}), 0.0);
  DOUBLES_EQUAL(1721.0 + 5.0, decode("63|8@0+ (1.0,1721)", {0, 0, 0, 0, 0, 0, 0, 5}), 0.0);
  DOUBLES_EQUAL(3.0, decode("11|2@1+ (1,0)", {0x00, 0x18}), 0.0);
  DOUBLES_EQUAL(0x01020304050607p0, decode("15|56@0+ (1,0)", {0, 1, 2, 3, 4, 5, 6, 7}), 0.0);
  DOUBLES_EQUAL(25.0, decode("0|16@1+ (1E-2,-1.0E2)", {0xD4, 0x30}), 1e-12);
}

TEST(DbcFile, FloatingPointComesFromItsValueType) {
  const DbcFile dbc(
      scratch.write("a.dbc", "BO_ 1 F: 8 X\n SG_ S : 0|32@1- (2,0) [0|0] \"\" X\nSIG_VALTYPE_ 1 S : 1;\n"));
  const Frame frame{1, 8, {0x00, 0x00, 0xC0, 0x3F}};
  const DbcSignal& signal = dbc.messages()[0].signals[0];
  DOUBLES_EQUAL(3.0, signal.value(signal.raw(frame)), 0.0);
}

TEST(DbcFile, LongNameOfASignalIsItsName) {
  const DbcFile dbc(scratch.write("a.dbc",
                                  "BO_ 1 F: 8 X\n SG_ Short : 0|8@1+ (1,0) [0|0] \"\" X\n"
                                  "BA_ \"SystemSignalLongSymbol\" SG_ 1 Short \"Long_Name\";\n"));
  CHECK(dbc.messages()[0].find("Long_Name") != nullptr);
}

TEST(DbcFile, MultiplexedSignalIsThereInItsCaseOnly) {
  const DbcFile dbc(
      scratch.write("a.dbc",
                    "BO_ 1 F: 8 X\n SG_ Mux M : 0|8@1+ (1,0) [0|0] \"\" X\n"
                    " SG_ A m0 : 8|8@1+ (1,0) [0|0] \"\" X\n SG_ B m1 : 8|8@1+ (1,0) [0|0] \"\" X\n"));
  const DbcMessage& message = dbc.messages()[0];
  const Frame frame{1, 8, {1, 42}};
  CHECK_FALSE(raw_value(message, *message.find("A"), frame).has_value());
  LONGS_EQUAL(42, *raw_value(message, *message.find("B"), frame));
  const Frame cut{1, 1, {1}};
  CHECK_FALSE(raw_value(message, *message.find("B"), cut).has_value());
}

TEST(DbcFile, InvalidCodesAreTheEndsOfASignalOfAByteOrMore) {
  const DbcFile dbc(
      scratch.write("a.dbc",
                    "BO_ 1 F: 8 X\n SG_ U : 0|16@1+ (1,0) [0|0] \"\" X\n SG_ I : 16|16@1- (1,0) [0|0] \"\" X\n"
                    " SG_ Flag : 32|1@1+ (1,0) [0|0] \"\" X\n"));
  const DbcMessage& message = dbc.messages()[0];
  CHECK(message.find("U")->is_invalid_code(0xFFFF));
  CHECK_FALSE(message.find("U")->is_invalid_code(0xFFFE));
  CHECK(message.find("I")->is_invalid_code(0x7FFF));
  CHECK(message.find("I")->is_invalid_code(0x8000));
  CHECK_FALSE(message.find("I")->is_invalid_code(0xFFFF));
  CHECK_FALSE(message.find("Flag")->is_invalid_code(1));
}

TEST(DbcFile, CommentsOverSeveralLinesAndUnusedSignalsAreNoFrames) {
  const DbcFile dbc(
      scratch.write("a.dbc",
                    "VERSION \"\"\nBO_ 3221225472 VECTOR__INDEPENDENT_SIG_MSG: 0 Vector__XXX\n"
                    " SG_ Old : 0|16@1+ (1,0) [0|0] \"\" X\n\nBO_ 1 F: 1 X\n SG_ S : 0|8@1+ (1,0) [0|0] \"\" X\n"
                    "CM_ BO_ 1 \"first\nBO_ 1 F: 8 X\n SG_ broken\nlast\";\n"));
  LONGS_EQUAL(1, dbc.messages().size());
  LONGS_EQUAL(1, dbc.messages()[0].signals.size());
}

TEST(DbcFile, WhatCannotBeReadExactlyIsRefusedByFileAndLine) {
  STRCMP_CONTAINS("a.dbc:2: found frame 0x1 for the second time",
                  complaint_of("BO_ 1 F: 8 X\nBO_ 1 G: 8 X\n").c_str());
  STRCMP_CONTAINS(
      "a.dbc:3: found signal Blank for the second time",
      complaint_of("BO_ 1 F: 8 X\n SG_ Blank : 0|8@1+ (1,0) [0|0] \"\" X\n SG_ Blank : 8|8@1+ (1,0) [0|0] \"\" X\n")
          .c_str());
  STRCMP_CONTAINS("ends in byte 8", complaint_of("BO_ 1 F: 8 X\n SG_ S : 60|8@1+ (1,0) [0|0] \"\" X\n").c_str());
  STRCMP_CONTAINS("nested", complaint_of("BO_ 1 F: 8 X\n SG_ S m1M : 0|8@1+ (1,0) [0|0] \"\" X\n").c_str());
  STRCMP_CONTAINS(
      "a second multiplexer",
      complaint_of("BO_ 1 F: 8 X\n SG_ S M : 0|8@1+ (1,0) [0|0] \"\" X\n SG_ T M : 8|8@1+ (1,0) [0|0] \"\" X\n")
          .c_str());
  STRCMP_CONTAINS("a number", complaint_of("BO_ 1 F: 8 X\n SG_ S : x|8@1+ (1,0) [0|0] \"\" X\n").c_str());
  STRCMP_CONTAINS("no frame (BO_)", complaint_of("VERSION \"\"\n").c_str());
}
