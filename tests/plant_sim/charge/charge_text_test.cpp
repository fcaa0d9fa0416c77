// SPDX-License-Identifier: Apache-2.0
#include "charge/charge_text.hpp"

#include <set>
#include <string>

#include <CppUTest/TestHarness.h>

using namespace voltlap;
using namespace voltlap::plant;

TEST_GROUP(ChargeText){};

TEST(ChargeText, TimesHaveTheUnitThatAPersonReads) {
  STRCMP_EQUAL("12 s", duration_words(12.2).c_str());
  STRCMP_EQUAL("4 min 05 s", duration_words(245.0).c_str());
  STRCMP_EQUAL("15 h 48 min", duration_words(15 * 3600 + 48 * 60 + 31).c_str());
}

TEST(ChargeText, EveryEndHasItsOwnWords) {
  ChargeResult r;
  std::set<std::string> words;
  r.phase = can::ChargePhase::kStopped;
  for (std::size_t i = 0; i < std::size(can::kChargeReasonNames); ++i) {
    r.reason = static_cast<can::ChargeReason>(i);
    words.insert(ending_words(r));
  }
  UNSIGNED_LONGS_EQUAL(std::size(can::kChargeReasonNames), words.size());
  r.reason = can::ChargeReason::kFault;
  r.faults = 1U << static_cast<unsigned>(can::BmsFault::kCellVoltageHigh);
  STRCMP_EQUAL("broken off: the BMS has a fault: CellVoltageHigh", ending_words(r).c_str());
  r.phase = can::ChargePhase::kWaiting;
  r.reason = can::ChargeReason::kTemperature;
  r.end_temperature_max_c = 61.04;
  STRCMP_EQUAL("the time is over; last: the cells are too hot (hottest 61.0 degC)", ending_words(r).c_str());
  r.too_cold = r.idle = true;
  r.end_temperature_min_c = -5.0;
  STRCMP_EQUAL("not begun: the cells are too cold (coldest -5.0 degC)", ending_words(r).c_str());
  r.full = true;
  STRCMP_EQUAL("every cell is full, and all are even", ending_words(r).c_str());
}
