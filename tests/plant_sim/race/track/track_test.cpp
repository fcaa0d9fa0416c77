// SPDX-License-Identifier: Apache-2.0
#include "race/track/track.hpp"

#include "fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

namespace {

std::string refusal(const TemporaryFile& file) {
  return input_error([&] { static_cast<void>(load_track(file.path())); });
}

void check_refused(const std::string& text, const std::string& place, const char* why) {
  const TemporaryFile file("track.csv", text);
  STRCMP_CONTAINS((file.path() + place).c_str(), refusal(file).c_str());
  STRCMP_CONTAINS(why, refusal(file).c_str());
}

}  // namespace

TEST_GROUP(Track){};

TEST(Track, MichiganCoursesHaveTheirPublishedLengths) {
  DOUBLES_EQUAL(814.1, michigan(2015).length_m(), 0.1);
  DOUBLES_EQUAL(746.9, michigan(2014).length_m(), 0.1);
  STRCMP_EQUAL("michigan_2015", michigan(2015).name.c_str());
}

TEST(Track, AStraightAndACornerBecomeTwoSegments) {
  const TemporaryFile file("track.csv", "# a comment\nstraight_m,corner_radius_m,corner_angle_rad\n20.0,10.0,-1.5\n");
  const Track track = load_track(file.path());
  LONGS_EQUAL(2, track.segments.size());
  DOUBLES_EQUAL(20.0, track.segments[0].length_m, 0.0);
  DOUBLES_EQUAL(0.0, track.segments[0].curvature_per_m, 0.0);
  DOUBLES_EQUAL(15.0, track.segments[1].length_m, 1e-12);
  DOUBLES_EQUAL(-0.1, track.segments[1].curvature_per_m, 1e-12);
}

TEST(Track, ACornerOfNoAngleAndAStraightOfNoLengthAreNoSegments) {
  const TemporaryFile file("track.csv", "straight_m,corner_radius_m,corner_angle_rad\n30.0,5.0,0.0\n0.0,10.0,1.0\n");
  const Track track = load_track(file.path());
  LONGS_EQUAL(2, track.segments.size());
  DOUBLES_EQUAL(40.0, track.length_m(), 1e-12);
}

TEST(Track, TypedSectionsTurnLeftAndRight) {
  const TemporaryFile file("track.csv",
                           "type,section_length_m,corner_radius_m\nStraight,30.0,0.0\nLeft,10.0,5.0\nRight,4.0,8.0\n");
  const Track track = load_track(file.path());
  LONGS_EQUAL(3, track.segments.size());
  DOUBLES_EQUAL(-0.2, track.segments[1].curvature_per_m, 1e-12);
  DOUBLES_EQUAL(0.125, track.segments[2].curvature_per_m, 1e-12);
}

TEST(Track, ARadiusThatIsNotPositiveIsRefusedWithFileAndLine) {
  check_refused("straight_m,corner_radius_m,corner_angle_rad\n30.0,5.0,1.0\n30.0,-5.0,1.0\n", ":3",
                "corner_radius_m: found -5");
  check_refused("type,section_length_m,corner_radius_m\nLeft,10.0,0.0\n", ":2", "corner_radius_m: found 0");
}

TEST(Track, AnglesMayBeGivenInDegrees) {
  const TemporaryFile radians("radians.csv", "straight_m,corner_radius_m,corner_angle_rad\n60,8,3.14159265358979\n");
  const TemporaryFile degrees("degrees.csv", "straight_m,corner_radius_m,corner_angle_deg\n60,8,-180\n");
  DOUBLES_EQUAL(load_track(radians.path()).length_m(), load_track(degrees.path()).length_m(), 1e-9);
  DOUBLES_EQUAL(-0.125, load_track(degrees.path()).segments[1].curvature_per_m, 0.0);
}

TEST(Track, AnAngleBeyondAFullCircleIsRefusedAndDegreesAreNamed) {
  const TemporaryFile file("half.csv", "straight_m,corner_radius_m,corner_angle_rad\n60,8,180\n60,8,180\n");
  const std::string error = input_error([&] { static_cast<void>(load_track(file.path())); });
  STRCMP_CONTAINS("half.csv:2, corner_angle_rad: found 180; expected at most a full circle, 6.283 radians",
                  error.c_str());
  STRCMP_CONTAINS("Degrees go into a column corner_angle_deg", error.c_str());
  const TemporaryFile circle("circle.csv", "straight_m,corner_radius_m,corner_angle_rad\n60,8,6.2832\n");
  DOUBLES_EQUAL(60.0 + 8.0 * 6.2832, load_track(circle.path()).length_m(), 1e-9);
}

TEST(Track, ANegativeLengthIsRefusedWithFileAndLine) {
  check_refused("straight_m,corner_radius_m,corner_angle_rad\n-1.0,5.0,1.0\n", ":2", "straight_m: found -1");
}

TEST(Track, AMissingColumnIsNamedTogetherWithThoseThereAre) {
  check_refused("straight_m,corner_angle_rad\n30.0,1.0\n", "",
                "found the columns straight_m,corner_angle_rad; expected a column corner_radius_m");
}

TEST(Track, AWordInPlaceOfANumberIsRefusedWithFileAndLine) {
  check_refused("straight_m,corner_radius_m,corner_angle_rad\n\n30.0,five,1.0\n", ":3",
                "corner_radius_m: found \"five\"");
  check_refused("straight_m,corner_radius_m,corner_angle_rad\n30.0,nan,1.0\n", ":2", "corner_radius_m: found \"nan\"");
}

TEST(Track, ARowOfAnotherLengthThanTheHeaderIsRefused) {
  check_refused("straight_m,corner_radius_m,corner_angle_rad\n30.0,5.0\n", ":2", "found 2 fields; expected 3");
}

TEST(Track, AnUnknownTypeIsRefused) {
  check_refused("type,section_length_m,corner_radius_m\nChicane,10.0,5.0\n", ":2", "type: found \"Chicane\"");
}

TEST(Track, ACourseBelowTenMetresIsRefused) {
  check_refused("straight_m,corner_radius_m,corner_angle_rad\n9.9,5.0,0.0\n", "",
                "found a track of 9.9 m; expected 10 to 1000000 m");
}

TEST(Track, AFileThatDoesNotExistOrHasNoRowsIsRefused) {
  STRCMP_CONTAINS("no file that can be opened",
                  input_error([] { static_cast<void>(load_track("/nowhere/track.csv")); }).c_str());
  check_refused("straight_m,corner_radius_m,corner_angle_rad\n", "", "found a header line and no row");
}
