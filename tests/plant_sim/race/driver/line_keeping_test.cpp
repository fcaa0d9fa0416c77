// SPDX-License-Identifier: Apache-2.0
#include "race/driver/line_keeping.hpp"

#include <cmath>
#include <optional>

#include "car/vehicle/grip.hpp"
#include "fixtures.hpp"
#include "race/track/lap_solver.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

namespace {

constexpr double kStep_s = 0.001;

}  // namespace

TEST_GROUP(LineKeeping) {
  VehicleParameters car = vtm16e();
  std::optional<LineKeeping> line{std::in_place, car};
  Target here{};

  /// Drives on for a time at one speed and returns the share of the grip that was left for the pedals, at the end.
  double drive(double seconds, double speed_mps) {
    Road road;
    here.speed_mps = speed_mps;
    for (int i = 0; i < std::lround(seconds / kStep_s); ++i) {
      road = line->road(here, speed_mps);
      line->advance(speed_mps * kStep_s, kStep_s);
    }
    return road.longitudinal_share;
  }
};

TEST(LineKeeping, WithinTheGripTheCarIsOnItsLineToTheLastBit) {
  here.curvature_per_m = -0.1;
  drive(3.0, 0.9999 * corner_speed(car, 0.1));
  DOUBLES_EQUAL(0.0, line->offset_m(), 0.0);
  DOUBLES_EQUAL(2.9997 * corner_speed(car, 0.1), line->distance_m(), 1e-6);
}

TEST(LineKeeping, CorneringTakesItsShareOfTheEllipse) {
  here.curvature_per_m = 0.1;
  const double v = corner_speed(car, 0.1);
  DOUBLES_EQUAL(0.0, drive(0.01, v), 1e-3);
  DOUBLES_EQUAL(std::sqrt(1.0 - 0.36), drive(0.01, v * std::sqrt(0.6)), 1e-4);
  here.curvature_per_m = 0.0;
  DOUBLES_EQUAL(1.0, drive(0.01, v), 0.0);
}

TEST(LineKeeping, WhoIsTooFastRunsWideToTheOutsideOnALongerWay) {
  for (const double side : {1.0, -1.0}) {
    line.emplace(car);
    here.curvature_per_m = side * 0.1;
    const double v = 1.05 * corner_speed(car, 0.1);
    const double share = drive(0.8, v);
    CHECK(side * line->offset_m() < -0.1);
    CHECK(line->distance_m() < 0.8 * v - 0.005);
    CHECK(share > 0.3);  // the steering is opened to brake
  }
}

TEST(LineKeeping, WhoIsFasterThanPlannedOpensTheSteeringToBrake) {
  here.curvature_per_m = 0.1;
  const double v = corner_speed(car, 0.1);
  here.speed_mps = v - 0.5;
  CHECK(line->road(here, v).longitudinal_share > 0.5);
  here.speed_mps = v;
  CHECK(line->road(here, v).longitudinal_share < 0.01);
}

TEST(LineKeeping, FasterIsWider) {
  double widest = 0.0;
  for (const double factor : {1.02, 1.05, 1.1, 1.3, 2.0}) {
    line.emplace(car);
    here.curvature_per_m = 0.1;
    drive(0.5, factor * corner_speed(car, 0.1));
    CHECK(-line->offset_m() > widest);
    widest = -line->offset_m();
  }
}

TEST(LineKeeping, WithGripToSpareTheCarComesBackToItsLine) {
  here.curvature_per_m = 0.1;
  drive(0.8, 1.05 * corner_speed(car, 0.1));
  CHECK(line->offset_m() < 0.0);
  Target eased = here;
  eased.speed_mps = 10.0;
  CHECK(line->eased(eased).speed_mps < 10.0);
  here.curvature_per_m = 0.0;
  drive(12.0, 10.0);
  DOUBLES_EQUAL(0.0, line->offset_m(), 0.01);
}

TEST(LineKeeping, ACarThatStandsStaysWhereItIs) {
  here.curvature_per_m = 0.2;
  drive(0.5, 1.3 * corner_speed(car, 0.2));
  const double offset = line->offset_m(), distance = line->distance_m();
  drive(5.0, 0.0);
  DOUBLES_EQUAL(offset, line->offset_m(), 1e-12);
  DOUBLES_EQUAL(distance, line->distance_m(), 1e-12);
}
