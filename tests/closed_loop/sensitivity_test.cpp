// SPDX-License-Identifier: Apache-2.0
// What a change of the car costs, on the lap as it is calculated and on the road as it is driven: the same.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "loop.hpp"
#include "plant_sim/fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

namespace {

struct Change {
  const char* name;
  void (*apply)(VehicleParameters&);
};

constexpr Change kChanges[] = {
    {"grip -20 %", [](VehicleParameters& c) { c.tyres.pacejka_d *= 0.8; }},
    {"grip -40 %", [](VehicleParameters& c) { c.tyres.pacejka_d *= 0.6; }},
    {"mass +20 %", [](VehicleParameters& c) { c.vehicle.mass_kg *= 1.2; }},
    {"drag +30 %", [](VehicleParameters& c) { c.aero.drag_coefficient *= 1.3; }},
    {"power -30 %", [](VehicleParameters& c) { c.inverter.current_max_a *= 0.7; }},
};

Segment straight(double length_m) { return {length_m, 0.0, "course"}; }
Segment corner(double radius_m, double angle_deg) {
  return {radius_m * std::abs(angle_deg) * M_PI / 180.0, std::copysign(1.0 / radius_m, angle_deg), "course"};
}

/// The two shipped courses, an oval, hairpins, a slalom with sweepers, a long straight that begins in a braking zone.
std::vector<Track> six_courses() {
  Track oval{"oval", {straight(80.0), corner(20.0, 180.0), straight(80.0), corner(20.0, 180.0)}};
  Track hairpins{"hairpins", {straight(50.0), corner(4.5, 180.0), straight(50.0), corner(4.5, -180.0), straight(30.0),
                              corner(8.0, 90.0), straight(25.0), corner(8.0, 90.0)}};
  Track slalom{"slalom", {}};
  for (int gate = 0; gate < 10; ++gate) slalom.segments.push_back(corner(9.0, gate % 2 == 0 ? 60.0 : -60.0));
  slalom.segments.push_back(straight(30.0));
  slalom.segments.push_back(corner(30.0, 180.0));
  slalom.segments.push_back(straight(120.0));
  slalom.segments.push_back(corner(30.0, 180.0));
  Track braking{"braking", {straight(10.0), corner(7.0, 180.0), straight(200.0), corner(12.0, 180.0), straight(190.0)}};
  return {michigan(2014), michigan(2015), oval, hairpins, slalom, braking};
}

/// Of a lap that begins as it ends: the second one.
double driven_lap_s(const VehicleParameters& car, const Track& track) {
  EnduranceOptions options = nominal(2);
  options.vehicle = car;
  options.track = track;
  const EnduranceResult r = drive(options);
  if (!r.finished) FAIL(r.failure_cause.c_str());
  return r.lap_rows.back().time_s;
}

}  // namespace

TEST_GROUP(Sensitivity){};

TEST(Sensitivity, WhatAChangeCostsOnTheRoadIsWhatItCostsOnTheLap) {
  const VehicleParameters car = vtm16e();
  for (const Track& track : six_courses()) {
    const double lap_s = solve_lap(car, track, LapStart::kFlying).lap_time_s(), road_s = driven_lap_s(car, track);
    for (const Change& change : kChanges) {
      VehicleParameters changed = car;
      change.apply(changed);
      const double lap_loss_s = solve_lap(changed, track, LapStart::kFlying).lap_time_s() - lap_s;
      const double road_loss_s = driven_lap_s(changed, track) - road_s;
      const std::string found = fmt::format("{} on {}: the lap loses {:.3f} s, the road {:.3f} s", change.name,
                                            track.name, lap_loss_s, road_loss_s);
      CHECK_TEXT(lap_loss_s > 0.0 && road_loss_s > 0.0, found.c_str());
      CHECK_TEXT(std::abs(road_loss_s - lap_loss_s) < std::max(0.05 * lap_loss_s, 0.02), found.c_str());
    }
  }
}
