// SPDX-License-Identifier: Apache-2.0
#include "race/track/import/gps.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/demand.hpp"
#include "core/errors.hpp"
#include "io/line_reader.hpp"

namespace voltlap::plant {
namespace {

constexpr double kEquator_m = 6378137.0;
constexpr double kFlattening = 1.0 / 298.257223563;
constexpr double kRadiansPerDegree = M_PI / 180.0;
constexpr double kFarthest_m = 50e3;

void check_range(const GpsPlace& place) {
  const auto refuse = [&](const char* what, double found, double most) {
    throw InputError(fmt::format("{}, {}", place.place, what), fmt::format("{:g}", found),
                     fmt::format("-{:g} to {:g} degrees", most, most),
                     "Give decimal degrees; check that latitude and longitude are not exchanged");
  };
  if (!(std::abs(place.latitude_deg) <= 90.0)) refuse("latitude", place.latitude_deg, 90.0);
  if (!(std::abs(place.longitude_deg) <= 180.0)) refuse("longitude", place.longitude_deg, 180.0);
}

/// Value of `name="..."` in a tag; throws InputError with the line.
double attribute(const std::string& tag, const std::string& name, const std::string& place) {
  for (const char quote : {'"', '\''}) {
    const std::size_t at = tag.find(' ' + name + '=' + quote);
    if (at == std::string::npos) continue;
    const std::size_t from = at + name.size() + 3, end = tag.find(quote, from);
    const std::string text = tag.substr(from, end - from);
    double value = 0.0;
    const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error == std::errc{} && rest == text.data() + text.size() && std::isfinite(value)) return value;
    throw InputError(fmt::format("{}, {}", place, name), '"' + text + '"', "decimal degrees", "Correct the point");
  }
  throw InputError(place, "a point without " + name, "lat and lon", "Correct the point");
}

/// `<name ...>`: whether a tag is one of these.
bool is_tag(const std::string& tag, const std::string& name) {
  return tag.starts_with('<' + name + ' ') || tag.starts_with('<' + name + '\n') || tag.starts_with('<' + name + '\t');
}

}  // namespace

PointList in_the_plane(const std::vector<GpsPlace>& places) {
  VOLTLAP_DEMAND(!places.empty());
  for (const GpsPlace& place : places) check_range(place);
  const GpsPlace origin = places[places.size() / 2];
  const double phi = origin.latitude_deg * kRadiansPerDegree;
  const double e2 = kFlattening * (2.0 - kFlattening), w2 = 1.0 - e2 * std::sin(phi) * std::sin(phi);
  const double prime_vertical = kEquator_m / std::sqrt(w2), meridian = prime_vertical * (1.0 - e2) / w2;
  PointList points;
  for (const GpsPlace& place : places) {
    const double east = std::remainder(place.longitude_deg - origin.longitude_deg, 360.0) * kRadiansPerDegree;
    const double north = (place.latitude_deg - origin.latitude_deg) * kRadiansPerDegree;
    points.push_back({prime_vertical * std::cos(phi) * east, meridian * north});
    if (length(points.back()) > kFarthest_m) {
      throw InputError(place.place, fmt::format("a place {:.0f} km from the others", length(points.back()) / 1000.0),
                       "a course", "Remove the rows in which the GPS had no fix");
    }
  }
  return points;
}

std::vector<GpsPlace> read_gpx(const std::string& path) {
  LineReader reader(path, "a GPX file");
  std::vector<GpsPlace> track, others;
  std::string tag;
  bool open = false;
  std::string_view line;
  while (reader.next(line)) {
    for (const char c : line) {
      if (c == '<') tag.clear(), open = true;
      if (open) tag += c;
      if (c != '>' || !open) continue;
      open = false;
      const bool of_track = is_tag(tag, "trkpt");
      if (!of_track && !is_tag(tag, "rtept") && !is_tag(tag, "wpt")) continue;
      const std::string place = reader.place();
      (of_track ? track : others).push_back({attribute(tag, "lat", place), attribute(tag, "lon", place), place});
    }
    if (open) tag += '\n';
  }
  if (track.empty()) track = std::move(others);
  if (track.empty()) {
    throw InputError(path, "no trkpt", "track points of a GPX file", "Export the recording as a GPX track");
  }
  return track;
}

}  // namespace voltlap::plant
