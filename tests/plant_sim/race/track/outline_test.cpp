// SPDX-License-Identifier: Apache-2.0
#include "race/track/outline.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

TEST_GROUP(Outline){};

TEST(Outline, AStraightGoesAlongX) {
  const auto points = outline({"", {{30.0, 0.0}}}, 10.0);
  LONGS_EQUAL(4, points.size());
  DOUBLES_EQUAL(30.0, points.back().x_m, 1e-12);
  DOUBLES_EQUAL(0.0, points.back().y_m, 1e-12);
}

TEST(Outline, ARightTurnGoesBelowTheAxis) {
  const auto points = outline({"", {{5.0 * std::numbers::pi, 0.1}}}, 0.5);  // a quarter of a circle of 10 m
  DOUBLES_EQUAL(10.0, points.back().x_m, 1e-9);
  DOUBLES_EQUAL(-10.0, points.back().y_m, 1e-9);
}

TEST(Outline, AnArcEndsInTheSamePlaceWhateverTheStep) {
  const Track arc{"", {{7.0, -0.2}}};
  const OutlinePoint fine = outline(arc, 0.01).back(), coarse = outline(arc, 7.0).back();
  DOUBLES_EQUAL(fine.x_m, coarse.x_m, 1e-9);
  DOUBLES_EQUAL(fine.y_m, coarse.y_m, 1e-9);
  CHECK(fine.y_m > 0.0);
}

TEST(Outline, AFullCircleCloses) {
  const OutlinePoint end = outline({"", {{20.0 * std::numbers::pi, 0.1}}}, 1.0).back();
  DOUBLES_EQUAL(0.0, std::hypot(end.x_m, end.y_m), 1e-9);
}

TEST(Outline, MichiganHasItsLengthAndIsLeftOpenAsListed) {
  const auto points = outline(michigan(2015), 2.0);
  DOUBLES_EQUAL(814.1, points.back().distance_m, 0.1);
  for (std::size_t i = 1; i < points.size(); ++i)
    CHECK(points[i].distance_m - points[i - 1].distance_m <= 2.0 + 1e-9);
  DOUBLES_EQUAL(93.3, std::hypot(points.back().x_m, points.back().y_m), 0.1);
}

TEST(Outline, TheGapOfACourseIsSaidAndACircleHasNone) {
  DOUBLES_EQUAL(0.0, closing_gap_m({"", {{20.0 * std::numbers::pi, 0.1}}}), 1e-9);
  DOUBLES_EQUAL(30.0, closing_gap_m({"", {{30.0, 0.0}}}), 1e-9);
  STRCMP_EQUAL("62.8 m, closed", course_text(62.8, 0.1).c_str());
  STRCMP_EQUAL("814.1 m, its end 61 m away from its start: driven as a lap all the same",
               course_text(814.1, 61.2).c_str());
}
