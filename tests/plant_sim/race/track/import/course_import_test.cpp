// SPDX-License-Identifier: Apache-2.0
#include "race/track/import/course_import.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "drawn_course.hpp"
#include "fixtures.hpp"
#include "race/track/lap_solver.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

namespace {

ImportedCourse imported(const std::string& text, const ImportOptions& options = {}) {
  const TemporaryFile file("course.csv", text);
  return import_course(file.path(), options);
}
ImportedCourse imported(const PointList& points, const ImportOptions& options = {}) {
  return imported(points_file(points), options);
}
double lap_time(const Track& track, LapStart start = LapStart::kFlying) {
  return solve_lap(vtm16e(), track, start).lap_time_s();
}

Track drawn(unsigned seed) {
  std::mt19937_64 draw(seed);
  return drawn_closed_course(draw);
}
PointList exact(const Track& track, double spacing_m = 0.5) {
  std::mt19937_64 draw(1);
  return surveyed(track, spacing_m, 0.0, draw);
}

template <class Change>
PointList changed(PointList points, const Change& change) {
  for (PlanePoint& p : points) p = change(p);
  return points;
}

}  // namespace

TEST_GROUP(CourseImport){};

TEST(CourseImport, SegmentsAreTakenAsTheyAre) {
  for (const int year : {2014, 2015}) {
    const std::string path = fmt::format("{}/plant_sim/data/tracks/michigan_{}.csv", VOLTLAP_SOURCE_DIR, year);
    const ImportedCourse course = import_course(path, {});
    const TemporaryFile out("out.csv", course_file_text(course.track, ""));
    const ImportedCourse again = import_course(out.path(), {});
    LONGS_EQUAL(michigan(year).segments.size(), again.track.segments.size());
    for (std::size_t k = 0; k < again.track.segments.size(); ++k) {
      DOUBLES_EQUAL(michigan(year).segments[k].length_m, again.track.segments[k].length_m, 0.0);
      DOUBLES_EQUAL(michigan(year).segments[k].curvature_per_m, again.track.segments[k].curvature_per_m, 0.0);
    }
    DOUBLES_EQUAL(lap_time(michigan(year)), lap_time(again.track), 0.0);
  }
}

TEST(CourseImport, ARotatedShiftedMirroredOrReversedSourceIsAsFast) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    const std::string which = fmt::format("seed {}", seed);
    const PointList points = exact(drawn(seed));
    const double time = lap_time(imported(points).track);
    const auto rotated = [](PlanePoint p) {
      return PlanePoint{0.6 * p.x_m - 0.8 * p.y_m + 4e5, 0.8 * p.x_m + 0.6 * p.y_m - 5e6};
    };
    const auto mirrored = [](PlanePoint p) { return PlanePoint{p.x_m, -p.y_m}; };
    DOUBLES_EQUAL_TEXT(time, lap_time(imported(changed(points, rotated)).track), 1e-3 * time, which.c_str());
    DOUBLES_EQUAL_TEXT(time, lap_time(imported(changed(points, mirrored)).track), 1e-3 * time, which.c_str());
    PointList reversed = points;
    std::reverse(reversed.begin(), reversed.end());
    ImportOptions back;
    back.reversed = true;
    DOUBLES_EQUAL_TEXT(time, lap_time(imported(reversed, back).track), 1e-3 * time, which.c_str());
    PointList elsewhere = points;
    std::rotate(elsewhere.begin(), elsewhere.begin() + 333, elsewhere.end());
    DOUBLES_EQUAL_TEXT(time, lap_time(imported(elsewhere).track), 3e-3 * time, which.c_str());
  }
}

TEST(CourseImport, ASmoothCurveIsNotForcedIntoArcs) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    std::mt19937_64 draw(seed);
    std::uniform_real_distribution<double> share(0.0, 1.0);
    PointList points{{}};
    const double length_m = 30.0 + 40.0 * share(draw), swing = 0.03 + 0.05 * share(draw);
    double heading = 0.0;
    for (int i = 1; i <= 600; ++i) {  // its curvature changes all along
      heading += 0.5 * swing * std::sin(2.0 * M_PI * 0.5 * i / length_m);
      points.push_back(points.back() + PlanePoint{0.5 * std::cos(heading), 0.5 * std::sin(heading)});
    }
    CHECK_FALSE_TEXT(imported(points).of_segments, fmt::format("seed {}", seed).c_str());
  }
}

TEST(CourseImport, ACourseOfStraightsAndArcsComesAsThese) {
  for (unsigned seed = 11; seed <= 16; ++seed) {
    const ImportedCourse course = imported(exact(drawn(seed), 1.0));
    const std::string which = fmt::format("seed {}: {} segments", seed, course.track.segments.size());
    CHECK_TEXT(course.of_segments, which.c_str());
    CHECK_TEXT(course.track.segments.size() <= drawn(seed).segments.size() + 2, which.c_str());
  }
}

TEST(CourseImport, FeetAndMetresAgree) {
  const PointList points = exact(drawn(3));
  const auto in_feet = changed(points, [](PlanePoint p) { return (1.0 / 0.3048) * p; });
  const double time = lap_time(imported(points).track);
  DOUBLES_EQUAL(time, lap_time(imported(points_file(in_feet, "x_ft,y_ft\n")).track), 1e-3 * time);
}

TEST(CourseImport, ARoundCourseIsClosedWhetherItsFirstPointIsRepeatedOrNot) {
  PointList points = exact(drawn(2));
  for (int form = 0; form < 3; ++form) {
    if (form == 1) points.push_back(points.front());
    if (form == 2) points.resize(points.size() - 9);  // 4 m are missing
    const ImportedCourse course = imported(points);
    CHECK(course.closed);
    DOUBLES_EQUAL(0.0, summarise(course.track).gap_m, 1e-3);
    DOUBLES_EQUAL(drawn(2).length_m(), course.track.length_m(), 1.0);
  }
}

TEST(CourseImport, AnAutocrossStaysOpenAndIsClosedOnDemand) {
  PointList points = exact(drawn(2));
  points.resize(points.size() - 120);  // 60 m
  const ImportedCourse open = imported(points);
  CHECK_FALSE(open.closed);
  DOUBLES_EQUAL(60.0, open.source_gap_m, 8.0);
  DOUBLES_EQUAL(drawn(2).length_m() - 60.0, open.track.length_m(), 2.0);
  ImportOptions options;
  options.closure = Closure::kClosed;
  const ImportedCourse closed = imported(points, options);
  CHECK(closed.closed);
  DOUBLES_EQUAL(drawn(2).length_m(), closed.track.length_m(), 30.0);  // what was left out is anybody's guess
}

TEST(CourseImport, RepeatedPointsAStopAndAWayBackChangeNothing) {
  const Track course = drawn(4);
  const PointList points = exact(course);
  PointList stopped;
  for (std::size_t i = 0; i < points.size(); ++i) {
    stopped.push_back(points[i]);
    if (i % 50 == 0) stopped.push_back(points[i]);
    if (i != 400) continue;
    for (int k = 0; k < 40; ++k) stopped.push_back(points[i]);            // it stands
    for (std::size_t k = 1; k <= 6; ++k) stopped.push_back(points[i - k]);  // rolls back 3 m, and drives on
  }
  const double time = lap_time(imported(points).track);
  DOUBLES_EQUAL(time, lap_time(imported(stopped).track), 0.01 * time);
}

TEST(CourseImport, UnevenSpacingGivesTheSameCourse) {
  const Track course = drawn(5);
  std::mt19937_64 draw(5);
  std::uniform_int_distribution<int> skip(1, 8);
  const PointList dense = exact(course, 0.25);
  PointList uneven;
  for (std::size_t i = 0; i < dense.size(); i += static_cast<std::size_t>(skip(draw))) uneven.push_back(dense[i]);
  DOUBLES_EQUAL(lap_time(course), lap_time(imported(uneven).track), 0.015 * lap_time(course));
  DOUBLES_EQUAL(course.length_m(), imported(uneven).track.length_m(), 0.002 * course.length_m());
}

TEST(CourseImport, ACourseThatCrossesItselfIsOneCourse) {
  PointList eight;
  for (int i = 0; i < 600; ++i) {
    const double t = 2.0 * M_PI * i / 600.0;
    eight.push_back({60.0 * std::sin(t), 30.0 * std::sin(2.0 * t)});
  }
  const ImportedCourse course = imported(eight);
  CHECK(course.closed);
  const CourseSummary sum = summarise(course.track);
  DOUBLES_EQUAL(0.0, sum.turned_deg, 0.5);
  DOUBLES_EQUAL(0.0, sum.gap_m, 1e-3);
  LONGS_EQUAL(2, sum.corners);
}

TEST(CourseImport, OneLapOfSeveralOrTheirMean) {
  const Track course = drawn(6);
  std::mt19937_64 draw(6);
  const PointList points = recorded(vtm16e(), course, 10.0, 0.3, 3.5, draw);
  const ImportedCourse mean = imported(points);
  LONGS_EQUAL(3, mean.laps);
  LONGS_EQUAL(3, mean.laps_used);
  ImportOptions options;
  options.lap = 2;
  const ImportedCourse second = imported(points, options);
  LONGS_EQUAL(1, second.laps_used);
  CHECK(second.points_used < mean.points_used / 2);
  options.lap = 4;
  STRCMP_CONTAINS("--lap: found 4; expected a lap of the 3 found", input_error([&] {
                    static_cast<void>(imported(points, options));
                  }).c_str());
}

TEST(CourseImport, GatesFarApartGiveARoundCourseThroughTheirMiddle) {
  const Track course = drawn(7);
  const ImportedCourse from = imported(exact(course, 8.0), {});
  CHECK(from.closed);
  STRCMP_CONTAINS("so few points", from.noise_origin.c_str());
  DOUBLES_EQUAL(course.length_m(), from.track.length_m(), 0.01 * course.length_m());
  DOUBLES_EQUAL(lap_time(course), lap_time(from.track), 0.15 * lap_time(course));
}

TEST(CourseImport, MoreNoiseGivenSmoothsMore) {
  const PointList points = exact(drawn(1));
  ImportOptions rough, smooth;
  rough.noise_m = 0.0;
  smooth.noise_m = 1.0;
  CHECK(summarise(imported(points, smooth).track).corners <= summarise(imported(points, rough).track).corners);
  CHECK(imported(points, smooth).track.segments.size() < imported(points, rough).track.segments.size());
}

TEST(CourseImport, WhatCannotBeACourseIsRefused) {
  const auto refusal = [](const std::string& text, const ImportOptions& options = {}) {
    return input_error([&] { static_cast<void>(imported(text, options)); });
  };
  STRCMP_CONTAINS("found 3 points; expected 8 or more", refusal("x_m,y_m\n0,0\n1,0\n1,1\n").c_str());
  std::string tiny = "x_m,y_m\n";
  for (int i = 0; i < 40; ++i) tiny += fmt::format("{},{}\n", 0.1 * i, 0.01 * i * i);
  STRCMP_CONTAINS("Check the unit", refusal("x_mm,y_mm" + tiny.substr(7)).c_str());
  ImportOptions noise;
  noise.noise_m = 1.0;
  STRCMP_CONTAINS("--noise: found it with segments",
                  refusal("type,section_length_m,corner_radius_m\nStraight,100,0\nLeft,50,20\n", noise).c_str());
}
