// SPDX-License-Identifier: Apache-2.0
#include "io/page/html_buckets.hpp"

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
  const auto buckets = growing_buckets(time_s, current_steps(current_a), 200);
  const HtmlSeries times = bucket_times(buckets, time_s), series = bucket_extremes(buckets, "v", 1.0, values);
  LONGS_EQUAL(times.size(), series.size());
  CHECK(times.size() <= 200);
  const auto encoded = [&](double first, double second) {
    values[4320] = first;
    values[4321] = second;
    return bucket_extremes(buckets, "v", 1.0, values).base64();
  };
  const std::string rising = encoded(-3.0, 7.0), falling = encoded(7.0, -3.0);
  CHECK(rising != falling);
  CHECK(encoded(-3.0, 6.0) != rising);
  CHECK(encoded(-2.0, 7.0) != rising);
  CHECK(encoded(6.0, -3.0) != falling);
  CHECK(encoded(7.0, -2.0) != falling);
}

TEST(HtmlBuckets, DriveFullOfStepsIsGatheredEvenly) {
  for (std::size_t row = 0; row < current_a.size(); ++row) current_a[row] = row % 2 == 0 ? 50.0 : -20.0;
  const auto buckets = growing_buckets(time_s, current_steps(current_a), 1000);
  CHECK(bucket_times(buckets, time_s).size() <= 1000);
  LONGS_EQUAL(5000, buckets.back().last);
}

TEST(HtmlBuckets, NoneReachesOverAGapAndTheLineBeginsAnewBehindIt) {
  std::vector<bool> begins(time_s.size(), false);
  begins[4321] = true;
  for (const bool drive : {false, true}) {
    for (std::size_t row = 0; drive && row < current_a.size(); ++row) current_a[row] = row % 2 == 0 ? 50.0 : -20.0;
    const auto buckets = growing_buckets(time_s, current_steps(current_a), 400, begins);
    std::size_t points = 0;
    for (const RowBucket& b : buckets) {
      CHECK(b.last <= 4321 || b.first >= 4321);
      if (b.last <= 4321) points += b.last - b.first > 1 ? 2U : 1U;
    }
    const std::vector<std::size_t> found = bucket_begins(buckets, begins);
    LONGS_EQUAL(1, found.size());
    LONGS_EQUAL(points, found[0]);
    CHECK(bucket_times(buckets, time_s).size() <= 400);
  }
}

TEST(HtmlBuckets, ManyGapsEndTheSearchForFewerPoints) {
  const std::vector<bool> begins(time_s.size(), true);
  const auto buckets = growing_buckets(time_s, current_steps(current_a), 100, begins);
  LONGS_EQUAL(5000, buckets.size());
}

TEST(HtmlBuckets, NoBucketIsSoLongThatItsExtremesDrawASlope) {
  for (std::size_t row = 0; row < 500; ++row) current_a[2 * row] = 50.0;  // a drive, then a long rest
  const auto buckets = growing_buckets(time_s, current_steps(current_a), 1000);
  for (const RowBucket& b : buckets) CHECK(b.last - b.first <= 25);
}
