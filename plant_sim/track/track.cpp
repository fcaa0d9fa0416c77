// SPDX-License-Identifier: Apache-2.0
#include "track/track.hpp"

#include <cmath>
#include <filesystem>

#include <fmt/format.h>

#include "core/csv.hpp"
#include "core/errors.hpp"

namespace voltlap::plant {
namespace {

double length_at(const CsvTable& table, std::size_t row, const char* column) {
  const double length = table.number(row, column);
  if (length < 0.0) {
    throw InputError(fmt::format("{}: {} is {}, expected 0 or more metres", table.place(row), column, length));
  }
  return length;
}

double radius_at(const CsvTable& table, std::size_t row) {
  const double radius = table.number(row, "corner_radius_m");
  if (!(radius > 0.0)) {
    throw InputError(fmt::format("{}: corner_radius_m is {}, expected more than 0 metres (the sign of a turn belongs to "
                                 "corner_angle_rad or type)", table.place(row), radius));
  }
  return radius;
}

void add(Track& track, double length, double curvature) {
  if (length > 0.0) track.segments.push_back({length, curvature});
}

void read_straights_and_corners(const CsvTable& table, Track& track) {
  for (std::size_t row = 0; row < table.rows(); ++row) {
    add(track, length_at(table, row, "straight_m"), 0.0);
    const double radius = radius_at(table, row);
    const double angle = table.number(row, "corner_angle_rad");
    add(track, radius * std::abs(angle), std::copysign(1.0 / radius, angle));
  }
}

void read_typed_sections(const CsvTable& table, Track& track) {
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const std::string& type = table.text(row, "type");
    const double length = length_at(table, row, "section_length_m");
    if (type == "Straight") {
      add(track, length, 0.0);
    } else if (type == "Left" || type == "Right") {
      add(track, length, (type == "Left" ? -1.0 : 1.0) / radius_at(table, row));
    } else {
      throw InputError(fmt::format("{}: type is '{}', expected Straight, Left or Right", table.place(row), type));
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
  const CsvTable table(path);
  Track track{std::filesystem::path(path).stem().string(), {}};
  if (table.has("type")) {
    read_typed_sections(table, track);
  } else {
    read_straights_and_corners(table, track);
  }
  if (!(track.length_m() >= 10.0)) {
    throw InputError(fmt::format("{}: the track is {:.1f} m long, expected at least 10 m", path, track.length_m()));
  }
  return track;
}

}  // namespace voltlap::plant
