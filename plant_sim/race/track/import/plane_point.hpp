// SPDX-License-Identifier: Apache-2.0
// A place in the plane: x to the east or right, y to the north or up, in metres.
#pragma once
#include <cmath>
#include <vector>

namespace voltlap::plant {

struct PlanePoint {
  double x_m = 0.0, y_m = 0.0;
};

inline PlanePoint operator+(PlanePoint a, PlanePoint b) { return {a.x_m + b.x_m, a.y_m + b.y_m}; }
inline PlanePoint operator-(PlanePoint a, PlanePoint b) { return {a.x_m - b.x_m, a.y_m - b.y_m}; }
inline PlanePoint operator*(double s, PlanePoint a) { return {s * a.x_m, s * a.y_m}; }
inline double dot(PlanePoint a, PlanePoint b) { return a.x_m * b.x_m + a.y_m * b.y_m; }
/// Above 0 when b points to the left of a.
inline double cross(PlanePoint a, PlanePoint b) { return a.x_m * b.y_m - a.y_m * b.x_m; }
inline double length(PlanePoint a) { return std::hypot(a.x_m, a.y_m); }
inline PlanePoint left_of(PlanePoint a) { return {-a.y_m, a.x_m}; }

using PointList = std::vector<PlanePoint>;

}  // namespace voltlap::plant
