// SPDX-License-Identifier: Apache-2.0
#include "codec/refresh.hpp"

#include "CppUTest/TestHarness.h"
#include "base/units.hpp"

using namespace voltlap;

TEST_GROUP(Refresh) {
  Sample<Current> sample{};
  static Instant at(std::uint32_t ms) { return Instant::from_ms(ms); }
};

TEST(Refresh, GoodValueReplacesValueTimeAndQuality) {
  codec::refresh(sample, true, Current::from_raw(7), at(30));
  CHECK(sample.good());
  LONGS_EQUAL(7, sample.value.raw());
  LONGS_EQUAL(30, static_cast<long>(sample.time.ms()));
}

TEST(Refresh, ValueThatIsNotOkLeavesTheLastGoodOneAndItsTime) {
  codec::refresh(sample, true, Current::from_raw(7), at(30));
  codec::refresh(sample, false, Current::from_raw(9), at(40));
  CHECK(sample.quality == Quality::kInvalid);
  LONGS_EQUAL(7, sample.value.raw());
  LONGS_EQUAL(30, static_cast<long>(sample.time.ms()));
}

TEST(Refresh, SampleIsStaleFromItsTimeoutOn) {
  codec::refresh(sample, true, Current::from_raw(7), at(30));
  codec::expire(sample, 50, at(79));
  CHECK(sample.good());
  codec::expire(sample, 50, at(80));
  CHECK(sample.quality == Quality::kStale);
}

TEST(Refresh, SampleOfTheFutureIsStaleAndOneNeverReceivedStaysSo) {
  codec::expire(sample, 50, at(1'000));
  CHECK(sample.quality == Quality::kNone);
  codec::refresh(sample, true, Current::from_raw(7), at(30));
  codec::expire(sample, 50, at(29));
  CHECK(sample.quality == Quality::kStale);
}
