// SPDX-License-Identifier: Apache-2.0
#include "drawn_course.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "race/track/lap_solver.hpp"
#include "race/track/outline.hpp"

namespace voltlap::plant::test {
namespace {

struct Rounding {
  double cut_m, radius_m, turn_rad;  ///< what it takes from both sides; turn above 0 to the left
};

}  // namespace

Track drawn_closed_course(std::mt19937_64& draw) {
  std::uniform_real_distribution<double> share(0.0, 1.0);
  const int n = 14 + static_cast<int>(12.0 * share(draw));
  PointList vertex;
  for (int i = 0; i < n; ++i) {
    const double angle = 2.0 * M_PI * (i + 0.6 * (share(draw) - 0.5)) / n, radius = 55.0 + 75.0 * share(draw);
    vertex.push_back({radius * std::cos(angle), radius * std::sin(angle)});
  }
  const auto at = [&](int i) { return vertex[static_cast<std::size_t>((i + n) % n)]; };
  std::vector<Rounding> corner;
  for (int i = 0; i < n; ++i) {
    const PlanePoint in = at(i) - at(i - 1), out = at(i + 1) - at(i);
    const double turn = std::atan2(cross(in, out), dot(in, out)), half = std::tan(0.5 * std::abs(turn));
    const double room = 0.48 * std::min(length(in), length(out));
    const double wanted = std::max(4.5 * std::pow(8.0, share(draw)), 6.0 / std::abs(turn));
    const double radius = std::min(wanted, room / half);
    corner.push_back({radius * half, radius, turn});
  }
  Track track{"drawn", {}};
  for (int i = 0; i < n; ++i) {
    const Rounding &a = corner[static_cast<std::size_t>(i)], &b = corner[static_cast<std::size_t>((i + 1) % n)];
    track.segments.push_back({length(at(i + 1) - at(i)) - a.cut_m - b.cut_m, 0.0});
    track.segments.push_back({b.radius_m * std::abs(b.turn_rad), -std::copysign(1.0 / b.radius_m, b.turn_rad)});
  }
  return track;
}

PointList surveyed(const Track& track, double spacing_m, double noise_m, std::mt19937_64& draw, int rounds) {
  std::normal_distribution<double> noise(0.0, noise_m > 0.0 ? noise_m : 1.0);
  const double scale = noise_m > 0.0 ? 1.0 : 0.0;
  PointList points;
  const std::vector<OutlinePoint> shape = outline(track, spacing_m);
  for (int round = 0; round < rounds; ++round) {
    for (const OutlinePoint& p : shape) {
      const double x = scale * noise(draw), y = scale * noise(draw);
      points.push_back({p.x_m + x, p.y_m + y});
    }
  }
  return points;
}

PointList recorded(const VehicleParameters& car, const Track& track, double rate_hz, double noise_m, double laps,
                   std::mt19937_64& draw) {
  std::normal_distribution<double> noise(0.0, noise_m);
  const SpeedProfile lap = solve_lap(car, track, LapStart::kFlying);
  const std::vector<OutlinePoint> shape = outline(track, 0.1);
  PointList points;
  for (double time = 0.0; time < laps * lap.lap_time_s(); time += 1.0 / rate_hz) {
    const double in_lap = std::fmod(time + 0.3 * lap.lap_time_s(), lap.lap_time_s());
    const auto above = std::upper_bound(lap.time_s.begin() + 1, lap.time_s.end() - 1, in_lap);
    const auto k = static_cast<std::size_t>(above - lap.time_s.begin());
    const double share = (in_lap - lap.time_s[k - 1]) / (lap.time_s[k] - lap.time_s[k - 1]);
    const double distance = lap.distance_m[k - 1] + share * (lap.distance_m[k] - lap.distance_m[k - 1]);
    const auto place = std::lower_bound(shape.begin(), shape.end() - 1, distance,
                                        [](const OutlinePoint& p, double d) { return p.distance_m < d; });
    const double x = noise(draw), y = noise(draw);
    points.push_back({place->x_m + x, place->y_m + y});
  }
  return points;
}

std::string points_file(const PointList& points, const char* header) {
  std::string text = header;
  for (const PlanePoint& p : points) text += fmt::format("{},{}\n", p.x_m, p.y_m);
  return text;
}

}  // namespace voltlap::plant::test
