// SPDX-License-Identifier: Apache-2.0
#include "core/number_text.hpp"

#include <cmath>
#include <string>

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(NumberText) {};

TEST(NumberText, NoNumberHasAnExponentOrAMinusBeforeAZero) {
  STRCMP_EQUAL("<0.001", short_number(8.694e-27).c_str());
  STRCMP_EQUAL(">-0.001", short_number(-2e-5).c_str());
  STRCMP_EQUAL("0", short_number(-0.0).c_str());
  STRCMP_EQUAL("1.235", short_number(1.23456).c_str());
  STRCMP_EQUAL("12345", short_number(12345.4).c_str());
  for (double size = 1e-40; size < 1e12; size *= 3.7) {
    for (const double value : {size, -size}) CHECK(short_number(value).find('e') == std::string::npos);
  }
}

TEST(NumberText, WhatIsShownAsZeroIsZero) {
  CHECK_FALSE(std::signbit(shown(-0.0049, 2)));
  DOUBLES_EQUAL(0.0, shown(-0.0049, 2), 0.0);
  DOUBLES_EQUAL(-0.0051, shown(-0.0051, 2), 0.0);
}
