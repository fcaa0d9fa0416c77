// SPDX-License-Identifier: Apache-2.0
#include "race/track/track.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include <fmt/format.h>

#include "core/demand.hpp"
#include "core/errors.hpp"
#include "io/table_file.hpp"

namespace voltlap::plant {
namespace {

constexpr double kLengthMin_m = 10.0;
constexpr double kLengthMax_m = 1e6;

double length_at(const InputTable& table, std::size_t row, const char* column) {
  const double length = table.number(row, column);
  if (length < 0.0) {
    throw InputError(fmt::format("{}, {}", table.place(row), column), fmt::format("{}", length), "0 or more metres",
                     "Correct the length");
  }
  return length;
}

double radius_at(const InputTable& table, std::size_t row) {
  const double radius = table.number(row, "corner_radius_m");
  if (!(radius > 0.0)) {
    throw InputError(table.place(row) + ", corner_radius_m", fmt::format("{}", radius), "more than 0 metres",
                     "Give the radius without sign; right or left is the sign of the angle, or the type");
  }
  return radius;
}

/// Radians, from whichever of the two columns the file has.
double angle_at(const InputTable& table, std::size_t row) {
  const bool degrees = table.has("corner_angle_deg");
  const char* column = degrees ? "corner_angle_deg" : "corner_angle_rad";
  const double angle = table.number(row, column), most = degrees ? 360.0 : 2.0 * M_PI;
  // 6.2832 is a full circle in four decimals.
  if (std::abs(angle) > most * (1.0 + 1e-4)) {
    throw InputError(fmt::format("{}, {}", table.place(row), column), fmt::format("{:g}", angle),
                     fmt::format("at most a full circle, {:.4g} {}", most, degrees ? "degrees" : "radians"),
                     degrees ? "Correct the angle" : "Degrees go into a column corner_angle_deg; or correct the angle");
  }
  return degrees ? angle * M_PI / 180.0 : angle;
}

double grade_at(const InputTable& table, std::size_t row) {
  constexpr double kSteepest_pct = 30.0;
  if (!table.has("grade_pct")) return 0.0;
  const double grade = table.number(row, "grade_pct");
  if (std::abs(grade) > kSteepest_pct) {
    throw InputError(table.place(row) + ", grade_pct", fmt::format("{:g}", grade),
                     fmt::format("-{0:g} to {0:g} %", kSteepest_pct), "Correct the grade: rise in percent of distance");
  }
  return 0.01 * grade;
}

void add(Track& track, const InputTable& table, std::size_t row, double length, double curvature) {
  if (length > 0.0) track.segments.push_back({length, curvature, table.place(row), grade_at(table, row)});
}

void read_straights_and_corners(const InputTable& table, Track& track) {
  for (std::size_t row = 0; row < table.rows(); ++row) {
    add(track, table, row, length_at(table, row, "straight_m"), 0.0);
    const double radius = radius_at(table, row);
    const double angle = angle_at(table, row);
    add(track, table, row, radius * std::abs(angle), std::copysign(1.0 / radius, angle));
  }
}

void read_typed_sections(const InputTable& table, Track& track) {
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const std::string& type = table.text(row, "type");
    const double length = length_at(table, row, "section_length_m");
    if (type == "Straight") {
      add(track, table, row, length, 0.0);
    } else if (type == "Left" || type == "Right") {
      add(track, table, row, length, (type == "Left" ? -1.0 : 1.0) / radius_at(table, row));
    } else {
      throw InputError(table.place(row) + ", type", fmt::format("\"{}\"", type), "Straight, Left or Right",
                       "Choose one of the three");
    }
  }
}

}  // namespace

double Track::length_m() const {
  double sum = 0.0;
  for (const Segment& s : segments) sum += s.length_m;
  return sum;
}

Track load_track(const std::string& path) {
  const InputTable table(path);
  Track track{std::filesystem::path(path).stem().string(), {}};
  if (table.has("type")) {
    read_typed_sections(table, track);
  } else {
    read_straights_and_corners(table, track);
  }
  const double length = track.length_m();
  if (!(length >= kLengthMin_m && length <= kLengthMax_m)) {
    throw InputError(path, fmt::format("a track of {:g} m", length),
                     fmt::format("{:.0f} to {:.0f} m", kLengthMin_m, kLengthMax_m),
                     "Check the lengths; they are in metres, angles in radians");
  }
  VOLTLAP_DEMAND(std::all_of(track.segments.begin(), track.segments.end(), [](const Segment& s) {
    return s.length_m > 0.0 && std::isfinite(s.curvature_per_m);
  }));
  return track;
}

}  // namespace voltlap::plant
