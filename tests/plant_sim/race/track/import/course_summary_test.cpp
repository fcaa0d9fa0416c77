// SPDX-License-Identifier: Apache-2.0
#include "race/track/import/course_summary.hpp"

#include <cmath>
#include <random>

#include "fixtures.hpp"
#include "race/track/import/course_closing.hpp"
#include "drawn_course.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

namespace {

void check_same(const Track& wanted, const Track& found) {
  LONGS_EQUAL(wanted.segments.size(), found.segments.size());
  for (std::size_t k = 0; k < wanted.segments.size(); ++k) {
    DOUBLES_EQUAL(wanted.segments[k].length_m, found.segments[k].length_m, 0.0);
    DOUBLES_EQUAL(wanted.segments[k].curvature_per_m, found.segments[k].curvature_per_m, 0.0);
    DOUBLES_EQUAL(wanted.segments[k].grade, found.segments[k].grade, 0.0);
  }
}

}  // namespace

TEST_GROUP(CourseSummary){};

TEST(CourseSummary, WhatIsWrittenIsReadAgainToTheLastBit) {
  std::mt19937_64 draw(7);
  std::uniform_real_distribution<double> share(-1.0, 1.0);
  Track track{"drawn", {}};
  for (int k = 0; k < 3000; ++k) {
    const double radius = std::pow(10.0, 1.5 + 1.2 * share(draw));
    track.segments.push_back({5.0 + 4.0 * share(draw), k % 5 == 0 ? 0.0 : std::copysign(1.0 / radius, share(draw)), {},
                              k % 3 == 0 ? 0.01 * (5.0 * share(draw)) : 0.0});
  }
  const TemporaryFile file("written.csv", course_file_text(track, "# a comment\n"));
  check_same(track, load_track(file.path()));
}

TEST(CourseSummary, MichiganAsWrittenIsMichigan) {
  for (const int year : {2014, 2015}) {
    const TemporaryFile file("michigan.csv", course_file_text(michigan(year), ""));
    check_same(michigan(year), load_track(file.path()));
  }
}

TEST(CourseSummary, AnOvalHasTwoCornersAndCloses) {
  const CourseSummary sum =
      summarise({"oval", {{60.0, 0.0}, {8.0 * M_PI, 0.125}, {60.0, 0.0}, {4.0 * M_PI, 0.125}, {4.0 * M_PI, 0.125}}});
  LONGS_EQUAL(2, sum.corners);
  DOUBLES_EQUAL(120.0, sum.straights_m, 1e-9);
  DOUBLES_EQUAL(8.0, sum.tightest_radius_m, 1e-9);
  DOUBLES_EQUAL(60.0, sum.tightest_at_m, 1e-9);
  DOUBLES_EQUAL(360.0, sum.turned_deg, 1e-9);
  DOUBLES_EQUAL(0.0, sum.gap_m, 1e-6);
}

TEST(CourseSummary, AChicaneHasTwoCornersAndAKinkNone) {
  LONGS_EQUAL(2, summarise({"", {{20.0, 0.0}, {5.0, 0.1}, {5.0, -0.1}, {20.0, 0.0}}}).corners);
  LONGS_EQUAL(0, summarise({"", {{20.0, 0.0}, {1.0, 0.1}, {20.0, 0.0}}}).corners);
}

TEST(CourseSummary, ACourseThatMissesItsStartIsClosedWithLittleChange) {
  for (unsigned seed = 1; seed <= 50; ++seed) {
    std::mt19937_64 draw(seed);
    std::normal_distribution<double> off(0.0, 0.01);
    Track course = drawn_closed_course(draw);
    for (Segment& s : course.segments) s.curvature_per_m += off(draw) / s.length_m * (s.curvature_per_m != 0.0);
    const double before = summarise(course).gap_m, length = course.length_m();
    course.segments = closed_segments(course.segments);
    const CourseSummary sum = summarise(course);
    CHECK_TEXT(before > 0.01 && sum.gap_m < 1e-6, ("seed " + std::to_string(seed)).c_str());
    DOUBLES_EQUAL_TEXT(360.0, std::abs(sum.turned_deg), 1e-6, ("seed " + std::to_string(seed)).c_str());
    DOUBLES_EQUAL_TEXT(length, sum.length_m, 0.01 * length, ("seed " + std::to_string(seed)).c_str());
  }
}
