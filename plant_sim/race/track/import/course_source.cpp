// SPDX-License-Identifier: Apache-2.0
#include "race/track/import/course_source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/demand.hpp"
#include "core/errors.hpp"
#include "race/track/import/gps.hpp"
#include "race/track/import/source_columns.hpp"

namespace voltlap::plant {
namespace {

constexpr std::array<std::pair<const char*, SourceKind>, 5> kKinds = {{{"points", SourceKind::kPoints},
                                                                       {"gps", SourceKind::kGps},
                                                                       {"gates", SourceKind::kGates},
                                                                       {"curvature", SourceKind::kCurvature},
                                                                       {"segments", SourceKind::kSegments}}};

bool is_gpx(const std::string& path) {
  std::string name = path;
  std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::tolower(c); });
  return name.ends_with(".gpx") || name.ends_with(".gpx.gz");
}

void read_points(const SourceTable& table, const SourceColumns& columns, std::optional<double> unit,
                 CourseSource& out) {
  const bool named = !table.names().empty();
  if (!named && table.columns() != 2) {
    throw InputError(table.path(), fmt::format("{} columns without names", table.columns()), "two, x and y",
                     "Add a header line that names the columns");
  }
  const std::size_t x = named ? columns.at(Quantity::kX) : 0, y = named ? columns.at(Quantity::kY) : 1;
  const double metres = columns.metres_per_unit(Quantity::kX, unit);
  if (named && columns.metres_per_unit(Quantity::kY, unit) != metres) {
    throw InputError(table.path(), "x and y in different units", "one unit for both", "Correct the header line");
  }
  for (std::size_t row = 0; row < table.rows(); ++row) {
    out.points.push_back(metres * PlanePoint{table.number(row, x), table.number(row, y)});
  }
}

void read_gps(const SourceTable& table, const SourceColumns& columns, CourseSource& out) {
  const std::size_t latitude = columns.at(Quantity::kLatitude), longitude = columns.at(Quantity::kLongitude);
  std::vector<GpsPlace> places;
  std::size_t without = 0;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    // Loggers leave the field empty between two fixes, and write 0, 0 before the first.
    if (table.text(row, latitude).empty() && table.text(row, longitude).empty()) {
      ++without;
      continue;
    }
    const GpsPlace place{table.number(row, latitude), table.number(row, longitude), table.place(row)};
    if (place.latitude_deg == 0.0 && place.longitude_deg == 0.0) ++without;
    else places.push_back(place);
  }
  if (without > 0) out.notes.push_back(fmt::format("{} rows without a place left out", without));
  if (places.empty()) {
    throw InputError(table.path(), "no row with a place", "latitude and longitude", "Check the recording");
  }
  out.points = in_the_plane(places);
}

void read_gates(const SourceTable& table, const SourceColumns& columns, std::optional<double> unit,
                CourseSource& out) {
  const std::array<std::size_t, 4> at = {columns.at(Quantity::kLeftX), columns.at(Quantity::kLeftY),
                                         columns.at(Quantity::kRightX), columns.at(Quantity::kRightY)};
  const double metres = columns.metres_per_unit(Quantity::kLeftX, unit);
  double narrowest = 1e9, widest = 0.0;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const PlanePoint one = metres * PlanePoint{table.number(row, at[0]), table.number(row, at[1])};
    const PlanePoint other = metres * PlanePoint{table.number(row, at[2]), table.number(row, at[3])};
    out.points.push_back(0.5 * (one + other));
    narrowest = std::min(narrowest, length(one - other));
    widest = std::max(widest, length(one - other));
  }
  out.notes.push_back(fmt::format("the middle of each gate; gates {:.1f} to {:.1f} m wide", narrowest, widest));
}

/// Which way the points beside a curvature turn: +1 when its sign is that of a right turn in the plane, else -1.
double sign_by_points(const SourceTable& table, const SourceColumns& columns, std::size_t curvature) {
  const std::size_t x = columns.at(Quantity::kX), y = columns.at(Quantity::kY);
  double agreement = 0.0;
  const auto at = [&](std::size_t row) { return PlanePoint{table.number(row, x), table.number(row, y)}; };
  for (std::size_t row = 1; row + 1 < table.rows(); ++row) {
    agreement += table.number(row, curvature) * cross(at(row) - at(row - 1), at(row + 1) - at(row));
  }
  return agreement > 0.0 ? -1.0 : 1.0;
}

/// A segment about each sample, from the middle before it to the middle behind it.
void read_curvature(const SourceTable& table, const SourceColumns& columns, std::optional<double> unit,
                    CourseSource& out) {
  const std::size_t s = columns.at(Quantity::kDistance), k = columns.at(Quantity::kCurvature);
  const double metres = columns.metres_per_unit(Quantity::kDistance, unit);
  const double per_metre = 1.0 / columns.metres_per_unit(Quantity::kCurvature, unit ? unit : std::optional(metres));
  const bool has_points = columns.has(Quantity::kX) && columns.has(Quantity::kY);
  const double sign = has_points ? sign_by_points(table, columns, k) : 1.0;
  out.notes.push_back(has_points ? "left and right are those of x and y" : "curvature above 0 turns right");
  const std::size_t n = table.rows();
  for (std::size_t row = 0; row < n; ++row) {
    const double here = table.number(row, s), before = row == 0 ? here : table.number(row - 1, s);
    const double behind = row + 1 == n ? here : table.number(row + 1, s);
    if (row > 0 && !(here > before)) {
      throw InputError(fmt::format("{}, {}", table.place(row), table.names()[s]), fmt::format("{:g}", here),
                       fmt::format("more than {:g}, the one before", before), "Sort the rows by distance");
    }
    const double curvature = sign * per_metre * table.number(row, k);
    out.segments.push_back({0.5 * metres * (behind - before), curvature, table.place(row)});
  }
}

double positive(const SourceTable& table, std::size_t row, std::size_t column, bool zero_too) {
  const double value = table.number(row, column);
  if (value > 0.0 || (zero_too && value == 0.0)) return value;
  throw InputError(fmt::format("{}, {}", table.place(row), table.names()[column]), fmt::format("{:g}", value),
                   zero_too ? "0 or more" : "more than 0", "Correct the field");
}

void add_segment(CourseSource& out, double length, double curvature, const std::string& place) {
  if (length > 0.0) out.segments.push_back({length, curvature, place});
}

void read_typed_segments(const SourceTable& table, const SourceColumns& columns, std::optional<double> unit,
                         CourseSource& out) {
  const std::size_t type = columns.at(Quantity::kType), section = columns.at(Quantity::kSectionLength);
  const std::size_t radius = columns.at(Quantity::kRadius);
  const double metres = columns.metres_per_unit(Quantity::kSectionLength, unit);
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const double length = metres * positive(table, row, section, true);
    std::string word = table.text(row, type);
    std::transform(word.begin(), word.end(), word.begin(), [](unsigned char c) { return std::tolower(c); });
    if (word == "straight") add_segment(out, length, 0.0, table.place(row));
    else if (word == "left" || word == "right") {
      const double r = metres * positive(table, row, radius, false);
      add_segment(out, length, (word == "left" ? -1.0 : 1.0) / r, table.place(row));
    } else {
      throw InputError(fmt::format("{}, {}", table.place(row), table.names()[type]), '"' + table.text(row, type) + '"',
                       "Straight, Left or Right", "Choose one of the three");
    }
  }
}

/// Whether a course file of the program already.
bool is_course_file(const SourceTable& table) {
  const auto has = [&](const char* name) {
    return std::find(table.names().begin(), table.names().end(), name) != table.names().end();
  };
  if (table.separator() != ',' || !has("corner_radius_m")) return false;
  return (has("type") && has("section_length_m")) ||
         (has("straight_m") && (has("corner_angle_rad") || has("corner_angle_deg")));
}

void read_segments(const SourceTable& table, const SourceColumns& columns, std::optional<double> unit,
                   CourseSource& out) {
  if (is_course_file(table)) {
    static_cast<void>(columns.metres_per_unit(Quantity::kRadius, unit));
    out.segments = load_track(table.path()).segments;
    return;
  }
  if (columns.has(Quantity::kType)) return read_typed_segments(table, columns, unit, out);
  const std::size_t straight = columns.at(Quantity::kStraight), radius = columns.at(Quantity::kRadius);
  const std::size_t angle = columns.at(Quantity::kAngle);
  const double metres = columns.metres_per_unit(Quantity::kStraight, unit), radians = columns.radians_per_unit();
  for (std::size_t row = 0; row < table.rows(); ++row) {
    add_segment(out, metres * positive(table, row, straight, true), 0.0, table.place(row));
    const double r = metres * positive(table, row, radius, false), turn = radians * table.number(row, angle);
    add_segment(out, r * std::abs(turn), std::copysign(1.0 / r, turn), table.place(row));
  }
}

}  // namespace

const char* name_of(SourceKind kind) {
  for (const auto& [name, known] : kKinds) {
    if (known == kind) return name;
  }
  return "";
}

std::optional<SourceKind> source_kind_of(const std::string& name) {
  for (const auto& [known, kind] : kKinds) {
    if (name == known) return kind;
  }
  return std::nullopt;
}

CourseSource read_course_source(const std::string& path, const SourceOptions& options) {
  CourseSource out;
  if (is_gpx(path)) {
    if (options.kind && *options.kind != SourceKind::kGps) {
      throw InputError("--as", name_of(*options.kind), "gps for a GPX file", "Leave --as out");
    }
    out.kind = SourceKind::kGps;
    out.points = in_the_plane(read_gpx(path));
    return out;
  }
  const SourceTable table(path);
  const SourceColumns columns(table);
  out.kind = options.kind ? *options.kind : columns.kind();
  switch (out.kind) {
    case SourceKind::kPoints: read_points(table, columns, options.metres_per_unit, out); break;
    case SourceKind::kGps: read_gps(table, columns, out); break;
    case SourceKind::kGates: read_gates(table, columns, options.metres_per_unit, out); break;
    case SourceKind::kCurvature: read_curvature(table, columns, options.metres_per_unit, out); break;
    case SourceKind::kSegments: read_segments(table, columns, options.metres_per_unit, out); break;
  }
  VOLTLAP_DEMAND(!out.points.empty() || !out.segments.empty());
  return out;
}

}  // namespace voltlap::plant
