// SPDX-License-Identifier: Apache-2.0
// Cars and courses that are drawn: what holds for the shipped ones holds one step beside them. A failure names its
// seed.
#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "car/powertrain/full_torque.hpp"
#include "car/vehicle/grip.hpp"
#include "drawn.hpp"
#include "loop.hpp"
#include "plant_sim/fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

namespace {

constexpr int kRaces = 40;

class Draw : public Drawn {
 public:
  using Drawn::Drawn;
  Track course() {
    Track out;
    out.name = "drawn";
    const int pieces = whole(2, 14);
    for (int k = 0; k < pieces; ++k) {
      if (between(0.0, 1.0) < 0.8) out.segments.push_back({between(2.0, 80.0), 0.0, "drawn"});
      const double radius = std::exp(between(std::log(3.0), std::log(60.0)));
      const double angle = between(0.1, M_PI) * (between(0.0, 1.0) < 0.5 ? -1.0 : 1.0);
      out.segments.push_back({radius * std::abs(angle), std::copysign(1.0 / radius, angle), "drawn"});
    }
    return out;
  }

  VehicleParameters car() {
    VehicleParameters out = vtm16e();
    out.powertrain.final_drive = between(2.0, 4.5);
    out.brakes.force_scale = between(0.6, 1.5);
    out.vehicle.mass_kg = between(160.0, 320.0);
    out.aero.drag_coefficient = between(0.0, 8.0);
    out.battery.initial_soc = between(0.5, 1.0);
    out.tyres.pacejka_d = between(0.8, 2.2);
    out.tyres.lateral_grip = between(0.8, 1.2);
    out.aero.downforce_coefficient = between(0.0, 20.0);
    out.inverter.current_max_a = between(300.0, 550.0);
    if (between(0.0, 1.0) < 0.3) out.environment.wind_mps = between(0.0, 8.0);
    if (between(0.0, 1.0) < 0.3) out.tyres.cornering_stiffness_per_rad = between(10.0, 30.0);
    return out;
  }
};

/// What is wrong with a race that nothing limits; empty when nothing is.
std::string fault_of(const EnduranceOptions& options) {
  Record record;
  const EnduranceResult r = drive(options, record);
  const SpeedProfile lap = solve_lap(options.vehicle, options.track, LapStart::kFlying);
  if (!r.finished) return r.failure_cause;
  const auto slowest = std::min_element(record.samples.begin(), record.samples.end(),
                                        [](const auto& a, const auto& b) { return a.speed_mps < b.speed_mps; });
  const double least = *std::min_element(lap.speed_mps.begin(), lap.speed_mps.end());
  if (slowest->speed_mps < 0.5 * least) {
    return fmt::format("{:.2f} m/s at {:.2f} s, where no lap is slower than {:.2f}", slowest->speed_mps,
                       slowest->time_s, least);
  }
  const double laps_s = options.laps * lap.lap_time_s();
  if (r.total_time_s < 0.995 * laps_s) {
    return fmt::format("{:.2f} s beat the lap solver's {:.2f} s", r.total_time_s, laps_s);
  }
  if (r.energy_ledger_error_pct > 0.1) return fmt::format("the ledger is open by {:.3f} %", r.energy_ledger_error_pct);
  return {};
}

bool spins_its_wheels(const VehicleParameters& car) {
  const double full_n = FullTorque(car).torque_nm(10.0) * car.powertrain.final_drive / car.tyres.lap_radius_m;
  return full_n > drive_grip(car, 0.0, 1.0, 0.0);
}

/// What must cost time, on the lap and on the road.
struct Handicap {
  const char* name;
  void (*apply)(VehicleParameters&);
};
constexpr Handicap kHandicaps[] = {
    {"mass +20 %", [](VehicleParameters& c) { c.vehicle.mass_kg *= 1.2; }},
    {"grip -20 %", [](VehicleParameters& c) { c.tyres.pacejka_d *= 0.8; }},
    {"grip -40 %", [](VehicleParameters& c) { c.tyres.pacejka_d *= 0.6; }},
    {"power -30 %", [](VehicleParameters& c) { c.inverter.current_max_a *= 0.7; }},
    {"drag +30 %", [](VehicleParameters& c) { c.aero.drag_coefficient *= 1.3; }},
};

}  // namespace

TEST_GROUP(DrawnRaces) {
  const std::uint64_t drawn = drawn_seed();
  Draw draw{drawn};
};

TEST(DrawnRaces, ACarNeverStandsNeverBeatsTheLapSolverAndItsLedgerCloses) {
  for (int race = 0; race < kRaces; ++race) {
    EnduranceOptions options = nominal(2);
    options.vehicle = draw.car();
    options.track = draw.course();
    const std::string fault = fault_of(options);
    if (fault.empty()) continue;
    FAIL(fmt::format("VOLTLAP_TEST_SEED={}, race {}: {}", drawn, race, fault).c_str());
  }
}

// The lap solver promised this car more than the wheel that lifts first at speed allows: it ran wide and, eased by the
// driver, did not come back.
TEST(DrawnRaces, ACarWithDownforceStaysOnTheLineOfAFastCornerThatEndsInASlowOne) {
  EnduranceOptions options = nominal(2);
  VehicleParameters& car = options.vehicle;  // of race 38 of VOLTLAP_TEST_SEED=3657885282, with the end of its course
  car.powertrain.final_drive = 4.209;
  car.brakes.force_scale = 0.642;
  car.vehicle.mass_kg = 213.8;
  car.aero.drag_coefficient = 6.522;
  car.aero.downforce_coefficient = 19.68;
  car.battery.initial_soc = 0.633;
  car.tyres.pacejka_d = 2.176;
  car.tyres.lateral_grip = 1.093;
  car.inverter.current_max_a = 514.1;
  options.track = {"fast, slow",
                   {{24.7, 0.0}, {21.5, 1.0 / 10.33}, {275.0, 0.0}, {102.8, 1.0 / 47.97}, {45.3, 1.0 / 38.88}}};
  const EnduranceResult r = drive(options);
  STRCMP_EQUAL("", r.failure_cause.c_str());
  CHECK_TRUE(r.max_off_course_m < 0.1);
}

TEST(DrawnRaces, WhatTheLapSolverPromisesOfACornerTheRoadHolds) {
  for (int trial = 0; trial < 1000; ++trial) {
    const VehicleParameters car = draw.car();
    const double curvature = 1.0 / draw.between(3.0, 100.0), wind = car.environment.wind_mps;
    const auto spare = [&](double v) {
      return std::min(lateral_grip(car, v + wind), lateral_lift(car, v + wind)) - v * v * curvature;
    };
    const double v = corner_speed(car, curvature, wind);
    if (spare(0.9999 * v) >= 0.0 && (spare(1.0001 * v) < 0.0 || spare(1e3) >= 0.0)) continue;
    FAIL(fmt::format("VOLTLAP_TEST_SEED={}, trial {}: {:.3f} m/s in a corner of {:.1f} m, {:+.3f} m/s2 to spare", drawn,
                     trial, v, 1.0 / curvature, spare(v)).c_str());
  }
}

TEST(DrawnRaces, WhereverOnTheCourseALapBeginsItIsTheSameLap) {
  for (int race = 0; race < 10; ++race) {
    EnduranceOptions options = nominal(2);
    options.vehicle = draw.car();
    options.vehicle.environment.wind_mps = 0.0;  // it turns with the start line
    options.track = draw.course();
    const EnduranceResult here = drive(options);
    auto& segments = options.track.segments;
    const int start = draw.whole(1, static_cast<int>(segments.size()) - 1);
    std::rotate(segments.begin(), segments.begin() + start, segments.end());
    const EnduranceResult there = drive(options);
    if (here.finished && there.finished && std::abs(there.total_time_s / here.total_time_s - 1.0) < 0.01) continue;
    FAIL(fmt::format("VOLTLAP_TEST_SEED={}, race {}: {:.2f} s ({}) here, {:.2f} s ({}) from elsewhere", drawn, race,
                     here.total_time_s, here.failure_cause, there.total_time_s, there.failure_cause).c_str());
  }
}

TEST(DrawnRaces, NothingThatCostsTimeEverGainsIt) {
  for (int race = 0; race < 4 * kRaces; ++race) {
    VehicleParameters car = draw.car();
    const Track course = draw.course();
    // Drag helps a car to brake that its pads, not its tyres, hold back.
    car.brakes.force_scale = 3.0;
    const double before = solve_lap(car, course, LapStart::kFlying).lap_time_s();
    for (const Handicap& handicap : kHandicaps) {
      // A car that only its tyres hold back loses less to drag the heavier it is.
      if (std::string_view(handicap.name).starts_with("mass") && spins_its_wheels(car)) continue;
      VehicleParameters worse = car;
      handicap.apply(worse);
      const double after = solve_lap(worse, course, LapStart::kFlying).lap_time_s();
      if (after > 0.999 * before) continue;
      FAIL(fmt::format("VOLTLAP_TEST_SEED={}, race {}: {} turns {:.3f} s into {:.3f} s", drawn, race, handicap.name,
                       before, after).c_str());
    }
  }
}

TEST(DrawnRaces, TheSameCourseTwiceTakesTwiceTheTime) {
  for (int race = 0; race < 10; ++race) {
    EnduranceOptions options = nominal(4);
    options.vehicle = draw.car();
    options.vehicle.environment.wind_mps = 0.0;  // the second time round the course need not lie as it did the first
    options.track = draw.course();
    const double once = drive(options).total_time_s;
    auto& segments = options.track.segments;
    const std::vector<Segment> lap = segments;
    segments.insert(segments.end(), lap.begin(), lap.end());
    options.laps = 2;
    const double twice = drive(options).total_time_s;
    if (std::abs(twice / once - 1.0) < 0.003) continue;
    FAIL(fmt::format("VOLTLAP_TEST_SEED={}, race {}: {:.3f} s in four laps, {:.3f} s in two double ones", drawn, race,
                     once, twice).c_str());
  }
}
