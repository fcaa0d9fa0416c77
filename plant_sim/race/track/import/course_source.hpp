// SPDX-License-Identifier: Apache-2.0
// What a race team has of its course, read from a file: points, a GPS recording, cone gates, curvature over distance,
// or segments.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "race/track/import/plane_point.hpp"
#include "race/track/track.hpp"

namespace voltlap::plant {

enum class SourceKind { kPoints, kGps, kGates, kCurvature, kSegments };

/// "points", "gps", "gates", "curvature", "segments".
[[nodiscard]] const char* name_of(SourceKind kind);
[[nodiscard]] std::optional<SourceKind> source_kind_of(const std::string& name);

struct SourceOptions {
  std::optional<SourceKind> kind;      ///< none: from the columns or the type of the file
  std::optional<double> metres_per_unit;  ///< none: from the names of the columns
};

struct CourseSource {
  SourceKind kind = SourceKind::kPoints;
  PointList points;               ///< of points, GPS and gates: the middle of each gate
  std::vector<Segment> segments;  ///< of curvature and segments
  std::vector<std::string> notes;  ///< what was taken as what, in words
};

/// Throws InputError that names file, line and column for what cannot be used.
[[nodiscard]] CourseSource read_course_source(const std::string& path, const SourceOptions& options);

}  // namespace voltlap::plant
