// SPDX-License-Identifier: Apache-2.0
#include "race/track/import/course_source.hpp"

#include <cmath>

#include "fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

namespace {

CourseSource read(const std::string& text, SourceOptions options = {}) {
  const TemporaryFile file("source.csv", text);
  return read_course_source(file.path(), options);
}
std::string refusal(const std::string& text, SourceOptions options = {}) {
  return input_error([&] { static_cast<void>(read(text, options)); });
}

SourceOptions in_metres(double metres_per_unit) { return {std::nullopt, metres_per_unit}; }

void check_second_point(double x, double y, const CourseSource& source) {
  LONGS_EQUAL(2, source.points.size());
  DOUBLES_EQUAL(x, source.points[1].x_m, 1e-9);
  DOUBLES_EQUAL(y, source.points[1].y_m, 1e-9);
}

}  // namespace

TEST_GROUP(Source){};

TEST(Source, PointsAreReadHoweverTheyAreWritten) {
  for (const char* text : {
           "x_m,y_m\n0,0\n1.5,-2\n", "X [m];Y [m]\n0;0\n1,5;-2\n", "\xEF\xBB\xBFx (m)\ty (m)\r\n0\t0\r\n1,5\t-2,0\r\n",
           "Easting (m),Northing (m)\n0,0\n+1.5,-2.0\n", "# a survey\n time, x, y\ns,m,m\n0,0,0\n1,1.5,-2\n",
           "y_m,name,x_m,\n0,a,0,\n-2,b,1.5,\n", "x_m y_m\n0 0\n1.5   -2\n", "x_cm;y_cm\n0;0\n150;-200\n"}) {
    check_second_point(1.5, -2.0, read(text));
  }
}

TEST(Source, TwoColumnsWithoutAHeaderArePointsOfAGivenUnit) {
  check_second_point(1.5, -2.0, read("0,0\n1.5,-2\n", in_metres(1.0)));
  check_second_point(1.5, -2.0, read("0;0\n1,5;-2\n", in_metres(1.0)));
  check_second_point(0.3048, 0.6096, read("0 0\n1 2\n", in_metres(0.3048)));
}

TEST(Source, FeetBecomeMetresByNameAndByFlag) {
  check_second_point(0.3048, 0.6096, read("x_ft,y_ft\n0,0\n1,2\n"));
  check_second_point(0.3048, 0.6096, read("x,y\n0,0\n1,2\n", in_metres(0.3048)));
}

TEST(Source, AnUnknownUnitIsAskedFor) {
  STRCMP_CONTAINS("found no unit; expected metres or feet. Say --unit m or --unit ft",
                  refusal("x,y\n0,0\n1,2\n").c_str());
  STRCMP_CONTAINS("--unit: found another unit", refusal("x_ft,y_ft\n0,0\n1,2\n", in_metres(1.0)).c_str());
  STRCMP_CONTAINS("x and y in different units", refusal("x_ft,y_m\n0,0\n1,2\n").c_str());
}

TEST(Source, ColumnsThatAreNotKnownAreListed) {
  const std::string said = refusal("time,speed\n0,0\n1,2\n");
  STRCMP_CONTAINS("found the columns time, speed; expected x and y; latitude and longitude;", said.c_str());
  STRCMP_CONTAINS("found 3 columns without names", refusal("0,0,1\n1,2,1\n").c_str());
  STRCMP_CONTAINS("found the columns x_m; expected a column named y",
                  refusal("x_m\n1\n2\n", {SourceKind::kPoints, {}}).c_str());
}

TEST(Source, AWordOrNoNumberIsRefusedWithFileAndLine) {
  STRCMP_CONTAINS("source.csv:3, y_m: found \"nan\"; expected a finite number",
                  refusal("x_m,y_m\n0,0\n1,nan\n2,2\n").c_str());
  STRCMP_CONTAINS("source.csv:3, y_m: found \"\"", refusal("x_m,y_m\n0,0\n1,\n2,2\n").c_str());
  STRCMP_CONTAINS("source.csv:4, x_m: found \"far\"", refusal("x_m,y_m\n0,0\n1,1\nfar,2\n").c_str());
  STRCMP_CONTAINS("found an empty file", refusal("").c_str());
  STRCMP_CONTAINS("found a header line and no row", refusal("x_m,y_m\n").c_str());
}

TEST(Source, GpsRowsWithoutAFixAreLeftOutAndSaid) {
  const CourseSource source = read("Latitude;Longitude\n;\n0;0\n42,0;-84,0\n42,001;-84,0\n");
  LONGS_EQUAL(2, source.points.size());
  STRCMP_CONTAINS("2 rows without a place", source.notes.at(0).c_str());
  STRCMP_CONTAINS("source.csv:2, latitude: found 420", refusal("lat,lon\n420,8\n42,8\n").c_str());
}

TEST(Source, TheMiddleOfAGateIsTheCourse) {
  const CourseSource source = read("left_x_m,left_y_m,right_x_m,right_y_m\n0,2,0,-2\n10,4,10,0\n");
  LONGS_EQUAL(static_cast<int>(SourceKind::kGates), static_cast<int>(source.kind));
  DOUBLES_EQUAL(10.0, source.points[1].x_m, 1e-12);
  DOUBLES_EQUAL(2.0, source.points[1].y_m, 1e-12);
  STRCMP_CONTAINS("gates 4.0 to 4.0 m wide", source.notes.at(0).c_str());
}

TEST(Source, CurvatureIsASegmentAboutEachRow) {
  const CourseSource source = read("s_m,curvature_1pm\n0,0\n1,0.1\n3,-0.2\n");
  LONGS_EQUAL(3, source.segments.size());
  DOUBLES_EQUAL(0.5, source.segments[0].length_m, 1e-12);
  DOUBLES_EQUAL(1.5, source.segments[1].length_m, 1e-12);
  DOUBLES_EQUAL(0.1, source.segments[1].curvature_per_m, 1e-12);
  STRCMP_CONTAINS("source.csv:4, s_m: found 1", refusal("s_m,curvature_1pm\n0,0\n1,0.1\n1,0\n").c_str());
}

TEST(Source, TheSignOfACurvatureIsThatOfThePointsBesideIt) {
  const CourseSource source = read("s_m,x_m,y_m,curvature_1pm\n0,0,0,0.1\n1,1,0.05,0.1\n2,1.98,0.2,0.1\n");
  DOUBLES_EQUAL(-0.1, source.segments[1].curvature_per_m, 1e-12);  // it turns left
}

TEST(Source, CurvatureInFeetIsThatInMetres) {
  const CourseSource source = read("s_ft,curvature_1pft\n0,0\n10,0.01\n20,0\n");
  DOUBLES_EQUAL(3.048, source.segments[1].length_m, 1e-12);
  DOUBLES_EQUAL(0.01 / 0.3048, source.segments[1].curvature_per_m, 1e-12);
}

TEST(Source, SegmentsOfOtherProgramsAreRead) {
  const CourseSource typed =
      read("Type,Section Length,Corner Radius\nStraight,10,0\nLeft,5,20\nright,4,8\n", in_metres(1.0));
  DOUBLES_EQUAL(-0.05, typed.segments[1].curvature_per_m, 0.0);
  DOUBLES_EQUAL(0.125, typed.segments[2].curvature_per_m, 0.0);
  const CourseSource angled = read("straight_ft,radius_ft,angle_deg\n10,20,90\n");
  DOUBLES_EQUAL(3.048, angled.segments[0].length_m, 1e-12);
  DOUBLES_EQUAL(0.5 * M_PI * 6.096, angled.segments[1].length_m, 1e-12);
  STRCMP_CONTAINS("found no unit; expected degrees or radians",
                  refusal("straight_m,radius_m,angle\n10,20,90\n").c_str());
  STRCMP_CONTAINS("expected Straight, Left or Right", refusal("type,length_m,radius_m\nChicane,10,20\n").c_str());
}
