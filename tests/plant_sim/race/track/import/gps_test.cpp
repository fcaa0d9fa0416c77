// SPDX-License-Identifier: Apache-2.0
#include "race/track/import/gps.hpp"

#include <cmath>

#include "fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

namespace {

double distance(GpsPlace a, GpsPlace b) {
  const PointList plane = in_the_plane({a, b});
  return length(plane[1] - plane[0]);
}

}  // namespace

TEST_GROUP(Gps){};

TEST(Gps, AMinuteOfArcHasTheLengthThatTheEllipsoidGivesIt) {
  // Length of a degree on WGS84, National Geospatial-Intelligence Agency.
  DOUBLES_EQUAL(110574.3 / 60.0, distance({0.0, 8.0}, {1.0 / 60.0, 8.0}), 0.5);
  DOUBLES_EQUAL(111319.5 / 60.0, distance({0.0, 8.0}, {0.0, 8.0 + 1.0 / 60.0}), 0.5);
  DOUBLES_EQUAL(111131.7 / 60.0, distance({45.0, 8.0}, {45.0 + 1.0 / 60.0, 8.0}), 0.5);
  DOUBLES_EQUAL(78846.8 / 60.0, distance({45.0, 8.0}, {45.0, 8.0 + 1.0 / 60.0}), 0.5);
}

TEST(Gps, EastIsXAndNorthIsY) {
  const PointList plane = in_the_plane({{42.0, -84.0}, {42.001, -83.999}});
  CHECK(plane[1].x_m < 1.0 && plane[0].x_m < 0.0);  // about the second of the two
  CHECK(plane[1].y_m - plane[0].y_m > 100.0);
}

TEST(Gps, ACourseAcrossTheDateLineIsOnePiece) {
  DOUBLES_EQUAL(2.0 * 111319.5 * 1e-4, distance({0.0, 179.9999}, {0.0, -179.9999}), 0.01);
}

TEST(Gps, DegreesBeyondTheirRangeAndPlacesFarApartAreRefused) {
  const auto refusal = [](GpsPlace a) {
    return input_error([&] { static_cast<void>(in_the_plane({a, {42.0, -84.0, "f:3"}})); });
  };
  STRCMP_CONTAINS("f:2, latitude: found 91; expected -90 to 90 degrees", refusal({91.0, 8.0, "f:2"}).c_str());
  STRCMP_CONTAINS("f:2, longitude: found -184; expected -180 to 180 degrees", refusal({42.0, -184.0, "f:2"}).c_str());
  STRCMP_CONTAINS("km from the others", refusal({43.0, -84.0, "f:2"}).c_str());
}

TEST(Gps, GpxTrackPointsAreReadHoweverTheyAreWritten) {
  const TemporaryFile file("lap.gpx",
                           "<?xml version=\"1.0\"?><gpx>\n<wpt lat=\"1\" lon=\"2\"/><trk><trkseg>\n"
                           "<trkpt lat=\"42.5\" lon=\"-84.25\"><ele>3</ele></trkpt>"
                           "<trkpt\n lon='-84.5'\n lat='42.75'/>\n"
                           "</trkseg></trk></gpx>\n");
  const std::vector<GpsPlace> places = read_gpx(file.path());
  LONGS_EQUAL(2, places.size());
  DOUBLES_EQUAL(42.75, places[1].latitude_deg, 0.0);
  DOUBLES_EQUAL(-84.5, places[1].longitude_deg, 0.0);
}

TEST(Gps, AGpxFileWithoutPointsOrWithABadOneIsRefused) {
  const TemporaryFile empty("empty.gpx", "<gpx></gpx>\n");
  STRCMP_CONTAINS("found no trkpt", input_error([&] { static_cast<void>(read_gpx(empty.path())); }).c_str());
  const TemporaryFile bad("bad.gpx", "<gpx>\n<trkpt lat=\"north\" lon=\"8\"/></gpx>\n");
  STRCMP_CONTAINS("bad.gpx:2, lat: found \"north\"",
                  input_error([&] { static_cast<void>(read_gpx(bad.path())); }).c_str());
}
