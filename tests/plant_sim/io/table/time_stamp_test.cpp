// SPDX-License-Identifier: Apache-2.0
#include "io/table/time_stamp.hpp"

#include <cmath>

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

namespace {

StampSeconds read(std::initializer_list<const char*> texts, const char* column = "time") {
  std::vector<TimeStamp> stamps;
  for (const char* text : texts) stamps.push_back(time_stamp(text));
  return seconds_of(stamps, column);
}

}  // namespace

TEST_GROUP(TimeStamp){};

TEST(TimeStamp, ClocksOfTwoAndThreePartsAndDays) {
  DOUBLES_EQUAL(3723.25, read({"1:02:03.25"}).seconds[0], 1e-9);
  DOUBLES_EQUAL(2 * 86400.0 + 3.5, read({"2d 00:00:03.50"}).seconds[0], 1e-9);
  DOUBLES_EQUAL(754.5, read({"12:34.5"}).seconds[0], 1e-9);
  DOUBLES_EQUAL(45240.0, read({"12:34"}, "time (h:min)").seconds[0], 1e-9);
  DOUBLES_EQUAL(754.0, read({"12:34"}, "time (min:s)").seconds[0], 1e-9);
  STRCMP_CONTAINS("minutes", read({"12:34"}).why_not.value_or("").c_str());
}

TEST(TimeStamp, SameInstantInEveryForm) {
  const double wanted = 1583280000.0 + 36610.0;  // 4 March 2020, 10:10:10
  for (const char* text :
       {"2020-03-04 10:10:10", "2020-03-04T10:10:10Z", "2020-03-04T11:10:10+01:00", "04.03.2020 10:10:10",
        "04-Mar-2020 10:10:10", "4/3/2020 10:10:10 AM", "2020/03/04 10:10:10"})
    DOUBLES_EQUAL_TEXT(wanted, read({text}).seconds[0], 1e-6, text);
  DOUBLES_EQUAL(12 * 3600.0, read({"4/3/2020 10:10:10 PM"}).seconds[0] - wanted, 1e-6);
}

TEST(TimeStamp, DayAndMonthFollowFromTheColumnOrAreLeftOpen) {
  DOUBLES_EQUAL(86400.0, read({"12/03/2020", "13/03/2020"}).seconds[1] - read({"12/03/2020", "13/03/2020"}).seconds[0],
                1e-6);
  const auto one_day = read({"3/4/2020 23:59:59", "3/5/2020 00:00:00"}).seconds;
  DOUBLES_EQUAL(1.0, one_day[1] - one_day[0], 1e-6);
  CHECK(read({"01/02/2020", "04/07/2020", "09/11/2020"}).why_not.has_value());
}

TEST(TimeStamp, ClockOfTheDayPassesMidnight) {
  const auto read_on = read({"23:59:58", "23:59:59", "00:00:00", "00:00:01"});
  for (std::size_t k = 1; k < 4; ++k) DOUBLES_EQUAL(1.0, read_on.seconds[k] - read_on.seconds[k - 1], 1e-9);
  CHECK(!read_on.notes.empty());
}

TEST(TimeStamp, OtherTextIsNone) {
  for (const char* text :
       {"", "3.75", "-5", "1.234.567", "10.0.0.1", "12:61", "2020-13-01", "2020-02-30x", "a:b", "1e-5"})
    CHECK_TEXT(!time_stamp(text).is_stamp(), text);
  CHECK(std::isnan(read({"2023-02-30"}).seconds[0]));
}
