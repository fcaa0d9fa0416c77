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

TEST(NumberText, SignificantDigitsHaveNoExponentAtAnySize) {
  STRCMP_EQUAL("17400", significant(17434.0, 3).c_str());
  STRCMP_EQUAL("100000", significant(99999.0, 3).c_str());
  STRCMP_EQUAL("12.3", significant(12.34, 3).c_str());
  STRCMP_EQUAL("12", significant(12.04, 3).c_str());
  STRCMP_EQUAL("-0.00027", significant(-2.7e-4, 2).c_str());
  STRCMP_EQUAL("<0.000001", significant(8.694e-27, 2).c_str());
  STRCMP_EQUAL("0", significant(-0.0, 2).c_str());
  for (double size = 1e-40; size < 1e12; size *= 3.7) {
    for (const double value : {size, -size}) CHECK(significant(value, 3).find('e') == std::string::npos);
  }
}

TEST(NumberText, WhatIsNoNumberIsSaidInWords) {
  for (const double none : {std::nan(""), -std::nan(""), HUGE_VAL, -HUGE_VAL}) {
    STRCMP_EQUAL("not settled", short_number(none).c_str());
    STRCMP_EQUAL("not settled", significant(none, 3).c_str());
    STRCMP_EQUAL("not settled", interval_words(0.0, none).c_str());
    STRCMP_EQUAL("not settled", interval_words(none, 1.0).c_str());
  }
  STRCMP_EQUAL("0 to 39.6", interval_words(0.0, 39.6).c_str());
}

TEST(NumberText, WhatIsShownAsZeroIsZero) {
  CHECK_FALSE(std::signbit(shown(-0.0049, 2)));
  DOUBLES_EQUAL(0.0, shown(-0.0049, 2), 0.0);
  DOUBLES_EQUAL(-0.0051, shown(-0.0051, 2), 0.0);
}
