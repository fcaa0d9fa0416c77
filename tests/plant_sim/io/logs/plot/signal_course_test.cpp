// SPDX-License-Identifier: Apache-2.0
#include "io/logs/plot/signal_course.hpp"

#include <cmath>
#include <limits>

#include "courses.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

TEST_GROUP(SignalCourse){};

TEST(SignalCourse, ExtremesHaveTheirFirstTimes) {
  const SignalCourse course = course_of({{1.0, 5.0}, {2.0, -3.0}, {3.0, 9.0}, {4.0, 9.0}, {5.0, -3.0}});
  DOUBLES_EQUAL(-3.0, course.low(), 0.0);
  DOUBLES_EQUAL(2.0, course.low_at_s(), 0.0);
  DOUBLES_EQUAL(9.0, course.high(), 0.0);
  DOUBLES_EQUAL(3.0, course.high_at_s(), 0.0);
  DOUBLES_EQUAL(-3.0, course.last(), 0.0);
  LONGS_EQUAL(3, course.changes());
}

TEST(SignalCourse, WhatIsNoNumberIsCountedAndChangesNothing) {
  const SignalCourse course = course_of({{0.0, std::nan("")}, {1.0, 2.0}, {2.0, INFINITY}, {3.0, 2.0}});
  LONGS_EQUAL(2, course.samples());
  LONGS_EQUAL(2, course.missing());
  CHECK(course.is_constant());
  DOUBLES_EQUAL(2.0, course.high(), 0.0);
}

TEST(SignalCourse, DecimalsAreThoseOfTheValues) {
  LONGS_EQUAL(0, course_of_values({1.0, -40.0, 3e9}).decimals());
  LONGS_EQUAL(1, course_of_values({0.1 * 3, 20.0}).decimals());
  LONGS_EQUAL(3, course_of_values({3.3, 3.296}).decimals());
  LONGS_EQUAL(6, course_of_values({1.0 / 3.0}).decimals());
}

TEST(SignalCourse, AGapIsFarBeyondTheUsualInterval) {
  Samples samples;
  for (int i = 0; i < 1000; ++i) samples.emplace_back(0.01 * i, i);
  for (int i = 0; i < 1000; ++i) samples.emplace_back(30.0 + 0.01 * i, i);
  const SignalCourse course = course_of(samples);
  CHECK(course.gap_s() >= 0.1);
  CHECK(course.gap_s() < 1.0);
  DOUBLES_EQUAL(0.01, course.usual_interval_s(), 0.005);
}

TEST(SignalCourse, WhatIsSentOnChangeHasNoGapAtItsUsualPauses) {
  Samples samples;
  for (int i = 0; i < 200; ++i) samples.emplace_back(i * 7.0 + (i % 5), i % 3);
  CHECK(course_of(samples).gap_s() > 12.0);
}

TEST(SignalCourse, FewValuesAndSeldomChangesAreSteps) {
  std::vector<double> ramp, toggled, seldom;
  for (int i = 0; i < 1000; ++i) {
    ramp.push_back(0.37 * i);
    toggled.push_back(i % 2);
    seldom.push_back(i / 40);
  }
  CHECK_FALSE(course_of_values(ramp).is_stepped());
  CHECK(course_of_values(toggled).is_stepped());
  CHECK(course_of_values(seldom).is_stepped());
}

TEST(SignalCourse, CountersOfAnyWidthAreTold) {
  for (const int bits : {2, 4, 8, 16}) {
    std::vector<double> values;
    for (int i = 0; i < 1000; ++i) values.push_back(i % (1 << bits));
    CHECK(course_of_values(values).is_counter());
  }
}

TEST(SignalCourse, ASmoothSignalIsNeitherCounterNorNoise) {
  std::vector<double> values;
  for (int i = 0; i < 1000; ++i) values.push_back(std::round(100.0 * std::sin(0.05 * i)));
  CHECK_FALSE(course_of_values(values).is_counter());
  CHECK_FALSE(course_of_values(values).is_noise());
}

TEST(SignalCourse, AChecksumIsNoise) {
  std::vector<double> values;
  unsigned state = 1;
  for (int i = 0; i < 1000; ++i) {
    state = state * 1664525U + 1013904223U;
    values.push_back(state >> 24U);
  }
  CHECK(course_of_values(values).is_noise());
}
