// SPDX-License-Identifier: Apache-2.0
#include "race/driver/target.hpp"

#include <cmath>

#include "fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

namespace {

std::string drive_refusal(const std::string& text) {
  const TemporaryFile file("drive.csv", text);
  return input_error([&] { static_cast<void>(load_drive(file.path())); });
}

/// 1 m/s2 for 10 m, 10 m at that speed, then to rest: times follow from constant acceleration.
SpeedProfile three_phases() {
  const double v = std::sqrt(20.0);
  return {.distance_m = {0.0, 10.0, 20.0, 30.0},
          .speed_mps = {0.0, v, v, 0.0},
          .time_s = {0.0, 20.0 / v, 30.0 / v, 50.0 / v},
          .phase = {LapPhase::kAccelerate, LapPhase::kCorner, LapPhase::kBrake, LapPhase::kBrake},
          .curvature_per_m = {0.0, 0.0, 0.0, 0.0},
          .grade = {0.0, 0.0, 0.0, 0.0},
          .head_wind_mps = {0.0, 0.0, 0.0, 0.0}};
}

}  // namespace

TEST_GROUP(Target) {
  DriverSection driver = vtm16e().driver;
};

TEST(Target, EveryPhaseBringsItsFirstPedals) {
  auto cursor = TargetCursor::by_time(three_phases(), driver);
  const Target accelerates = cursor.at(1.0, 0.0), corners = cursor.at(5.5, 0.0), brakes = cursor.at(8.0, 0.0);
  DOUBLES_EQUAL(0.8, accelerates.accelerator_base, 0.0);
  DOUBLES_EQUAL(0.18, corners.accelerator_base, 0.0);
  DOUBLES_EQUAL(0.9, brakes.brake_base, 0.0);
  DOUBLES_EQUAL(0.0, brakes.accelerator_base, 0.0);
}

TEST(Target, ATraceInTimeHasTheAccelerationOfItsLapAsSlope) {
  auto cursor = TargetCursor::by_time(three_phases(), driver);
  const Target target = cursor.at(1.5, 0.0);
  DOUBLES_EQUAL(1.5, target.speed_mps, 1e-9);
  DOUBLES_EQUAL(1.0, target.slope_mps2, 1e-9);
}

TEST(Target, TheTiledTraceStartsAnewAtItsSeam) {
  const SpeedProfile lap = three_phases();
  auto cursor = TargetCursor::by_time(lap, driver);
  DOUBLES_EQUAL(0.0, cursor.at(lap.lap_time_s() - 1e-6, 0.0).speed_mps, 1e-4);
  for (const double laps : {1.0, 2.0, 26.0}) {
    const Target again = cursor.at(laps * lap.lap_time_s() + 1.5, 0.0);
    DOUBLES_EQUAL(1.5, again.speed_mps, 1e-9);
    DOUBLES_EQUAL(0.8, again.accelerator_base, 0.0);
  }
}

TEST(Target, AFlyingTargetFollowsThePositionRoundAfterRound) {
  const SpeedProfile lap = solve_lap(vtm16e(), michigan(2015), LapStart::kFlying);
  auto cursor = TargetCursor::by_position(lap, driver);
  for (const std::size_t i : {std::size_t{0}, lap.speed_mps.size() / 3, lap.speed_mps.size() - 2}) {
    DOUBLES_EQUAL(lap.speed_mps[i], cursor.at(0.0, lap.distance_m[i]).speed_mps, 1e-9);
    DOUBLES_EQUAL(lap.speed_mps[i], cursor.at(0.0, lap.distance_m[i] + 5.0 * lap.length_m() + 1e-9).speed_mps, 1e-6);
  }
}

TEST(Target, ASlopeInPositionIsTurnedIntoOneInTime) {
  const SpeedProfile lap = solve_lap(vtm16e(), michigan(2015), LapStart::kFlying);
  auto cursor = TargetCursor::by_position(lap, driver);
  const std::size_t i = lap.speed_mps.size() / 2;
  const double middle = 0.5 * (lap.distance_m[i] + lap.distance_m[i + 1]);
  const double acceleration = (lap.speed_mps[i + 1] - lap.speed_mps[i]) / (lap.time_s[i + 1] - lap.time_s[i]);
  DOUBLES_EQUAL(acceleration, cursor.at(0.0, middle).slope_mps2, 1e-9);
}

TEST(Target, ARecordedDriveWithPedalsUsesThem) {
  const TemporaryFile file("drive.csv",
                           "time_s,speed_mps,accelerator,brake\n5.0,0.0,0.3,0\n7.0,4.0,0.4,0\n8.0,0.0,0,0.6\n");
  const RecordedDrive drive = load_drive(file.path());
  DOUBLES_EQUAL(3.0, drive.duration_s(), 1e-12);
  DOUBLES_EQUAL(6.0, drive.length_m(), 1e-12);
  auto cursor = TargetCursor::recorded(drive, driver);
  const Target rising = cursor.at(1.0, 0.0);
  DOUBLES_EQUAL(2.0, rising.speed_mps, 1e-12);
  DOUBLES_EQUAL(2.0, rising.slope_mps2, 1e-12);
  DOUBLES_EQUAL(0.3, rising.accelerator_base, 0.0);
  DOUBLES_EQUAL(0.4, cursor.at(2.5, 0.0).accelerator_base, 0.0);
}

TEST(Target, ARecordedDriveWithoutPedalsTakesThemFromItsSlope) {
  const TemporaryFile file("drive.csv", "time_s,speed_mps\n0,0\n2,4\n4,4\n5,0\n6,0\n");
  auto cursor = TargetCursor::recorded(load_drive(file.path()), driver);
  DOUBLES_EQUAL(0.8, cursor.at(1.0, 0.0).accelerator_base, 0.0);
  DOUBLES_EQUAL(0.18, cursor.at(3.0, 0.0).accelerator_base, 0.0);
  DOUBLES_EQUAL(0.9, cursor.at(4.5, 0.0).brake_base, 0.0);
}

TEST(Target, ARecordedDriveIsDrivenOnceAndHoldsItsEnd) {
  const TemporaryFile file("drive.csv", "time_s,speed_mps\n0,0\n2,4\n3,6\n");
  auto cursor = TargetCursor::recorded(load_drive(file.path()), driver);
  DOUBLES_EQUAL(6.0, cursor.at(100.0, 0.0).speed_mps, 1e-12);
}

TEST(Target, ADriveThatCannotBeDrivenIsRefusedWithItsLine) {
  STRCMP_CONTAINS("drive.csv:3, time_s: found 1 after 1", drive_refusal("time_s,speed_mps\n1,0\n1,1\n").c_str());
  STRCMP_CONTAINS("drive.csv:3, speed_mps: found -1", drive_refusal("time_s,speed_mps\n0,0\n1,-1\n").c_str());
  STRCMP_CONTAINS(":2, accelerator: found 1.2",
                  drive_refusal("time_s,speed_mps,accelerator,brake\n0,0,1.2,0\n1,1,0,0\n").c_str());
  STRCMP_CONTAINS("expected a column brake",
                  drive_refusal("time_s,speed_mps,accelerator\n0,0,1\n1,1,0\n").c_str());
  STRCMP_CONTAINS("a drive of two or more", drive_refusal("time_s,speed_mps\n0,0\n").c_str());
}
