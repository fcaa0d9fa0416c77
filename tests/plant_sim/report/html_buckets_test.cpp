// SPDX-License-Identifier: Apache-2.0
#include "report/html_buckets.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(HtmlBuckets) {
  std::vector<double> time_s, current_a;
  void setup() override {
    for (int row = 0; row < 5000; ++row) {
      time_s.push_back(row);
      current_a.push_back(row >= 1000 && row < 1200 ? 100.0 : 0.0);
    }
  }
};

TEST(HtmlBuckets, RowsAfterAStepAreKeptAndLateOnesGathered) {
  const auto buckets = growing_buckets(time_s, current_steps(current_a), 2000);
  std::size_t last = 0;
  for (const RowBucket& b : buckets) {
    LONGS_EQUAL(last, b.first);
    last = b.last;
    if (b.first >= 1000 && b.first < 1040) LONGS_EQUAL(1, b.last - b.first);
    if (b.first > 1000 && b.first < 1200) CHECK(b.last <= 1200);
  }
  LONGS_EQUAL(5000, last);
  CHECK(bucket_times(buckets, time_s).size() <= 2000);
}

TEST(HtmlBuckets, NoExtremeIsLostAndTheirOrderIsKept) {
  std::vector<double> values(time_s.size(), 1.0);
  values[4321] = 7.0;
  values[4320] = -3.0;
  const auto buckets = growing_buckets(time_s, current_steps(current_a), 200);
  const HtmlSeries times = bucket_times(buckets, time_s), series = bucket_extremes(buckets, "v", 1.0, values);
  LONGS_EQUAL(times.size(), series.size());
  CHECK(times.size() <= 200);
  std::swap(values[4320], values[4321]);
  CHECK(series.base64() != bucket_extremes(buckets, "v", 1.0, values).base64());
  values[4320] = values[4321] = 1.0;
  CHECK(series.base64() != bucket_extremes(buckets, "v", 1.0, values).base64());
}

TEST(HtmlBuckets, DriveFullOfStepsIsGatheredEvenly) {
  for (std::size_t row = 0; row < current_a.size(); ++row) current_a[row] = row % 2 == 0 ? 50.0 : -20.0;
  const auto buckets = growing_buckets(time_s, current_steps(current_a), 1000);
  CHECK(bucket_times(buckets, time_s).size() <= 1000);
  LONGS_EQUAL(5000, buckets.back().last);
}
