// SPDX-License-Identifier: Apache-2.0
// Places on the WGS84 ellipsoid in the plane of a course.
//
//   x = N(phi_0) cos(phi_0) (lambda - lambda_0), y = M(phi_0) (phi - phi_0)                        about the middle
//   N = a / sqrt(1 - e^2 sin^2 phi), M = a (1 - e^2) / (1 - e^2 sin^2 phi)^(3/2)   radii of curvature, prime vertical
//                                                                                   and meridian
// Source: NIMA TR8350.2, 2000 (a, 1/f). Over a course of 1 km the plane errs by some centimetres.
#pragma once
#include <string>
#include <vector>

#include "race/track/import/plane_point.hpp"

namespace voltlap::plant {

struct GpsPlace {
  double latitude_deg, longitude_deg;
  std::string place{};  ///< "file:line", for messages
};

/// x to the east, y to the north. Throws InputError for a latitude beyond 90 or a longitude beyond 180 degrees, and for
/// places more than 50 km apart.
[[nodiscard]] PointList in_the_plane(const std::vector<GpsPlace>& places);

/// The track points of a GPX file, or its route or way points where it has no track. Throws InputError.
[[nodiscard]] std::vector<GpsPlace> read_gpx(const std::string& path);

}  // namespace voltlap::plant
