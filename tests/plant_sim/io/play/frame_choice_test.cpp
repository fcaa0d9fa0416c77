// SPDX-License-Identifier: Apache-2.0
#include "io/play/frame_choice.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

namespace {

constexpr std::uint32_t kLong = RecordedFrame::kExtendedFlag;

}  // namespace

TEST_GROUP(FrameChoice) {};

TEST(FrameChoice, IdentifiersAreHexadecimalAndLongOnesHave29Bits) {
  struct Case {
    const char* text;
    std::uint32_t first, last;
    const char* said;
  };
  for (const Case& c : {Case{"6B0", 0x6B0, 0x6B0, "0x6B0"}, Case{"0x6b0-6BF", 0x6B0, 0x6BF, "0x6B0-0x6BF"},
                        Case{"18FF1234", 0x18FF1234 | kLong, 0x18FF1234 | kLong, "0x18FF1234"},
                        Case{"0123", 0x123 | kLong, 0x123 | kLong, "0x00000123"},
                        Case{"800", 0x800 | kLong, 0x800 | kLong, "0x00000800"}, Case{"0-7FF", 0, 0x7FF, "0x000-0x7FF"},
                        Case{"1000-1FFFFFFF", 0x1000 | kLong, 0x1FFFFFFF | kLong, "0x00001000-0x1FFFFFFF"}}) {
    IdRange range;
    CHECK_TEXT(parse_id_range(c.text, range), c.text);
    CHECK_EQUAL_TEXT(c.first, range.first, c.text);
    CHECK_EQUAL_TEXT(c.last, range.last, c.text);
    STRCMP_EQUAL(c.said, id_range_text(range).c_str());
  }
}

TEST(FrameChoice, WhatIsNoIdentifierIsNone) {
  for (const char* text : {"", "0x", "6B0-", "-6B0", "6BF-6B0", "6B0-18FF1234", "xyz", "20000000", "6B0 ", "1-2-3"}) {
    IdRange range;
    CHECK_FALSE_TEXT(parse_id_range(text, range), text);
  }
}

TEST(FrameChoice, WithoutARangeEveryIdentifierIsChosen) {
  FrameChoice choice;
  CHECK(choice.has_id(0x123) && choice.has_id(0x123 | kLong));
  choice.ids = {{0x100, 0x10F}, {0x200, 0x200}};
  CHECK(choice.has_id(0x100) && choice.has_id(0x10F) && choice.has_id(0x200));
  CHECK(!choice.has_id(0xFF) && !choice.has_id(0x110) && !choice.has_id(0x100 | kLong));
}
