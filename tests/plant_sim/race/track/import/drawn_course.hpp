// SPDX-License-Identifier: Apache-2.0
// Closed courses drawn from a seed, and what a survey or a GPS would have recorded of a course.
#pragma once
#include <random>
#include <string>
#include <vector>

#include "core/parameters.hpp"
#include "race/track/import/plane_point.hpp"
#include "race/track/track.hpp"

namespace voltlap::plant::test {

/// A polygon about a field with its corners rounded: it closes exactly. 14 to 25 corners of 4.5 m radius and more, none
/// shorter than 6 m; 500 to 900 m.
[[nodiscard]] Track drawn_closed_course(std::mt19937_64& draw);

/// Points of `rounds` rounds, `spacing_m` apart, with normally distributed noise in x and in y.
[[nodiscard]] PointList surveyed(const Track& track, double spacing_m, double noise_m, std::mt19937_64& draw,
                                 int rounds = 1);

/// Points of `laps` laps of a car at the speed of its fastest, `rate_hz` a second, with noise. Begins within a lap.
[[nodiscard]] PointList recorded(const VehicleParameters& car, const Track& track, double rate_hz, double noise_m,
                                 double laps, std::mt19937_64& draw);

/// "x_m,y_m" with a line a point.
[[nodiscard]] std::string points_file(const PointList& points, const char* header = "x_m,y_m\n");

}  // namespace voltlap::plant::test
