// SPDX-License-Identifier: Apache-2.0
#include "race/track/lap_solver.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>

#include "car/vehicle/grip.hpp"
#include "fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

namespace {

/// Eq. 3.10-3.15 as they are printed: raise the speed until a tyre lifts or the lateral force is not enough.
double corner_speed_by_iteration(const VehicleParameters& car, double radius) {
  const double m = 315.0, g = 9.81, x = car.vehicle.cg_rear_fraction, h = car.vehicle.cg_height_m;
  double v = 0.5;
  for (;; v += 1e-4) {
    const double a_y = v * v / radius;
    const double lift = 0.5 * car.aero.downforce_coefficient * car.aero.frontal_area_m2 * 1.225 * v * v;
    const double front = m * (1.0 - x) * a_y * h / car.vehicle.track_front_m;
    const double rear = m * x * a_y * h / car.vehicle.track_rear_m;
    const double front_static = g * m * (1.0 - x) / 2.0 + lift / 4.0, rear_static = g * m * x / 2.0 + lift / 4.0;
    const double inner_front = front_static - front, inner_rear = rear_static - rear;
    const double grip =
        lateral_friction(car.tyres) * (inner_front + front_static + front + inner_rear + rear_static + rear);
    if (inner_front < 0.0 || inner_rear < 0.0 || grip < a_y * m) return v;
  }
}

double motor_torque_at(const MotorSection& motor, double rpm) {
  if (rpm >= motor.curve_speed_rpm.back()) return 0.0;
  std::size_t i = 1;
  while (motor.curve_speed_rpm[i] < rpm) ++i;
  const double x0 = motor.curve_speed_rpm[i - 1], x1 = motor.curve_speed_rpm[i];
  const double rise = motor.curve_torque_nm[i] - motor.curve_torque_nm[i - 1];
  return motor.curve_torque_nm[i - 1] + rise * (rpm - x0) / (x1 - x0);
}

/// Full acceleration by Eq. 3.2-3.9, the load transfer by iteration.
double full_acceleration(const VehicleParameters& car, double v) {
  const double m = 315.0, r = car.tyres.lap_radius_m;
  const double drag = 0.5 * 0.372 * 1.225 * v * v, rolling = 0.01 * m * 9.81;
  const double drive = motor_torque_at(car.motor, v / r * car.powertrain.final_drive * 30.0 / M_PI) *
                       car.powertrain.final_drive * car.powertrain.driveline_efficiency / r;
  double force = drive;
  for (int i = 0; i < 50; ++i) {
    const double lift = 0.5 * 0.014 * 0.12 * 1.225 * v * v;
    const double moved = (force - drag - rolling) * 0.33 / 1.54;
    force = std::min(drive, peak_friction(car.tyres) * (0.52 * m * 9.81 + 0.5 * lift + moved));
  }
  return (force - drag - rolling) / (m + car.powertrain.driveline_inertia_kg_m2 / (r * r));
}

Track straight(double length) { return {"straight", {{length, 0.0}}}; }
Track circle(double radius) { return {"circle", {{2.0 * M_PI * radius, 1.0 / radius}}}; }

}  // namespace

TEST_GROUP(LapSolver) {
  VehicleParameters car = vtm16e();

  // The equations of these tests have a curve that holds at any voltage.
  void setup() override { car.motor.curve_voltage_v = 0.0; }
  double lap_time(int year = 2015, LapStart start = LapStart::kFlying) const {
    return solve_lap(car, michigan(year), start).lap_time_s();
  }
};

TEST(LapSolver, CornerSpeedIsTheOneThatTheEquationsGiveByIteration) {
  for (const double radius : {3.0, 7.0, 15.0, 40.0}) {
    DOUBLES_EQUAL(corner_speed_by_iteration(car, radius), corner_speed(car, 1.0 / radius), 2e-4);
  }
}

TEST(LapSolver, ATallNarrowCarIsLimitedByTheWheelThatLifts) {
  const double by_grip = corner_speed(car, 0.1);
  car.vehicle.cg_height_m = 0.7;
  DOUBLES_EQUAL(corner_speed_by_iteration(car, 10.0), corner_speed(car, 0.1), 2e-4);
  CHECK(corner_speed(car, 0.1) < 0.8 * by_grip);
}

TEST(LapSolver, WithDownforceTheAxleThatLiftsFirstAtSpeedNeedNotBeTheOneAtRest) {
  car.tyres.pacejka_d = 2.2;
  car.aero.downforce_coefficient = 20.0;
  const AxleLift still = axle_lift(car, 0.0), fast = axle_lift(car, 40.0);
  CHECK(still.front_mps2 < still.rear_mps2);
  CHECK(fast.front_mps2 > fast.rear_mps2);
  for (const double radius : {10.0, 35.0, 50.0}) {
    DOUBLES_EQUAL(corner_speed_by_iteration(car, radius), corner_speed(car, 1.0 / radius), 2e-4);
  }
}

TEST(LapSolver, LeftAndRightCornersAreEquallyFast) {
  DOUBLES_EQUAL(corner_speed(car, 0.1), corner_speed(car, -0.1), 0.0);
}

TEST(LapSolver, AFlyingLapOfACircleTakesItsLengthOverItsCornerSpeed) {
  const SpeedProfile lap = solve_lap(car, circle(10.0), LapStart::kFlying);
  DOUBLES_EQUAL(2.0 * M_PI * 10.0 / corner_speed(car, 0.1), lap.lap_time_s(), 1e-9);
  DOUBLES_EQUAL(corner_speed(car, 0.1), lap.max_speed_mps(), 1e-12);
}

TEST(LapSolver, AStraightFromRestAgreesWithAFineIntegrationInTime) {
  const SpeedProfile lap = solve_lap(car, straight(75.0), LapStart::kStanding, 0.25);
  double v = 0.0, s = 0.0, t = 0.0;
  constexpr double kStep = 1e-5;
  while (s < 75.0) {
    const double middle = v + 0.5 * kStep * full_acceleration(car, v);
    v += kStep * full_acceleration(car, middle);
    s += kStep * middle;
    t += kStep;
  }
  DOUBLES_EQUAL(t, lap.lap_time_s(), 0.001 * t);
  DOUBLES_EQUAL(v, lap.speed_mps.back(), 0.001 * v);
}

TEST(LapSolver, ACornerIsReachedByBrakingAtFullPedal) {
  const Track track{"hook", {{100.0, 0.0}, {10.0, 0.2}}};
  const SpeedProfile lap = solve_lap(car, track, LapStart::kStanding, 0.1);
  const auto at = [&](double distance) {
    const auto& grid = lap.distance_m;
    return static_cast<std::size_t>(std::lower_bound(grid.begin(), grid.end(), distance - 1e-9) - grid.begin());
  };
  const std::size_t corner = at(100.0), before = at(98.0);
  DOUBLES_EQUAL(corner_speed(car, 0.2), lap.speed_mps[corner], 1e-9);
  CHECK(lap.phase[before] == LapPhase::kBrake);
  const double measured = (std::pow(lap.speed_mps[before], 2) - std::pow(lap.speed_mps[corner], 2)) / 4.0;
  const double v = 0.5 * (lap.speed_mps[before] + lap.speed_mps[corner]);
  const double force = 652.0 / 0.22 + 31.0 + 0.5 * 0.372 * 1.225 * v * v;
  DOUBLES_EQUAL(force / (315.0 + 0.632 / 0.0484), measured, 0.02);
}

TEST(LapSolver, RefiningTheGridTenfoldChangesTheLapTimeBelowATwentiethOfAPercent) {
  for (const int year : {2014, 2015}) {
    for (const LapStart start : {LapStart::kFlying, LapStart::kStanding}) {
      const double coarse = solve_lap(car, michigan(year), start, 1.0).lap_time_s();
      DOUBLES_EQUAL(solve_lap(car, michigan(year), start, 0.1).lap_time_s(), coarse, 0.0005 * coarse);
    }
  }
}

TEST(LapSolver, AFlyingLapEndsAtTheSpeedItBeganWithAndBeatsAStandingOne) {
  for (const int year : {2014, 2015}) {
    const SpeedProfile lap = solve_lap(car, michigan(year), LapStart::kFlying);
    DOUBLES_EQUAL(lap.speed_mps.front(), lap.speed_mps.back(), 1e-9);
    CHECK(lap.speed_mps.front() > 1.0);
    CHECK(lap.lap_time_s() < lap_time(year, LapStart::kStanding));
    DOUBLES_EQUAL(0.0, solve_lap(car, michigan(year), LapStart::kStanding).speed_mps.front(), 0.0);
  }
}

TEST(LapSolver, NoPointOfALapIsFasterThanItsCorner) {
  const SpeedProfile lap = solve_lap(car, michigan(2015), LapStart::kFlying);
  for (std::size_t i = 0; i < lap.speed_mps.size(); ++i) {
    CHECK(lap.speed_mps[i] <= corner_speed(car, lap.curvature_per_m[i]) + 1e-9);
  }
}

TEST(LapSolver, MassCostsTimeAndTorqueBrakesAndGripGainIt) {
  const double nominal = lap_time();
  const auto with = [this](auto change) {
    car = vtm16e();
    change(car);
    return lap_time();
  };
  CHECK(with([](auto& c) { c.vehicle.mass_kg += 30.0; }) > nominal);
  CHECK(with([](auto& c) { c.brakes.force_scale = 1.2; }) < nominal);
  CHECK(with([](auto& c) { c.tyres.pacejka_d = 1.6; }) < nominal);
  CHECK(with([](auto& c) { c.powertrain.driveline_efficiency = 0.8; }) > nominal);
  CHECK(with([](auto& c) { c.aero.drag_coefficient = 4.0; }) > nominal);
}

TEST(LapSolver, ACarThatCannotDriveIsRefusedWithTheReason) {
  car.motor.curve_torque_nm.assign(car.motor.curve_torque_nm.size(), 0.0);
  STRCMP_CONTAINS("car vtm16e on track michigan_2015: found a car that cannot drive",
                  input_error([this] { static_cast<void>(lap_time()); }).c_str());
}

TEST(LapSolver, ACornerWhoseCentreLiesInsideTheCarIsRefused) {
  const double half_width = 0.5 * std::max(car.vehicle.track_front_m, car.vehicle.track_rear_m);
  const auto refusal = [&](double radius) {
    const Track course{"bend", {{30.0, 0.0}, {radius, 1.0 / radius, "bend.csv:3"}}};
    return input_error([&] { static_cast<void>(solve_lap(car, course, LapStart::kFlying)); });
  };
  STRCMP_CONTAINS("bend.csv:3: found a corner", refusal(half_width - 1e-6).c_str());
  STRCMP_EQUAL("", refusal(half_width + 1e-6).c_str());
}

TEST(LapSolver, ACourseWithoutCornersIsDrivenAtTheSpeedWhereDriveAndResistanceMeet) {
  Track straight;
  straight.name = "straight";
  straight.segments = {{75.0, 0.0, "straight:1"}};
  const SpeedProfile lap = solve_lap(car, straight, LapStart::kFlying);
  CHECK(full_acceleration(car, lap.max_speed_mps() - 0.01) > 0.0);
  CHECK(full_acceleration(car, lap.max_speed_mps() + 0.01) < 0.0);
  DOUBLES_EQUAL(75.0 / lap.max_speed_mps(), lap.lap_time_s(), 1e-6);
}

// A low gear's motor holds its top speed hard: a step across it ended at a standstill, or made a slower lap than a
// pack of fewer cells.
TEST(LapSolver, DrawnLowGearsAndHillsAreDrivenAsOnAFinerGrid) {
  const char* given = std::getenv("VOLTLAP_TEST_SEED");
  const unsigned seed = given != nullptr ? static_cast<unsigned>(std::strtoul(given, nullptr, 10)) : 1U;
  std::mt19937 random(seed);
  const auto draw = [&random](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
  for (int k = 0; k < 40; ++k) {
    car.powertrain.final_drive = std::exp(draw(std::log(2.0), std::log(60.0)));
    car.tyres.pacejka_d = draw(0.8, 2.2);
    Track course = michigan(2015);
    const double hill = draw(0.0, 0.1);
    for (Segment& segment : course.segments) segment.grade = draw(-hill, hill);
    const auto at = [&](double step_m) { return solve_lap(car, course, LapStart::kFlying, step_m).lap_time_s(); };
    const double fine = at(0.1);
    const SimpleString drawn = StringFromFormat("VOLTLAP_TEST_SEED=%u, draw %d", seed, k);
    DOUBLES_EQUAL_TEXT(fine, at(1.0), 0.01 * fine, drawn.asCharString());
  }
}
