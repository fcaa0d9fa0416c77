// SPDX-License-Identifier: Apache-2.0
// A course file from what a race team has of its course.
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "race/track/import/course_source.hpp"
#include "race/track/import/course_summary.hpp"

namespace voltlap::plant {

enum class Closure { kRecognised, kClosed, kOpen };

struct ImportOptions {
  SourceOptions source;
  Closure closure = Closure::kRecognised;
  double noise_m = -1.0;               ///< of the points; below 0: measured from them
  bool reversed = false, mirrored = false;
  std::optional<std::size_t> lap{};    ///< one lap of several, from 1; none: the mean of all
  std::string name{};                  ///< none: that of the file
  std::function<void(const std::string&, double)> progress{};
};

struct ImportedCourse {
  Track track;
  SourceKind kind = SourceKind::kPoints;
  bool closed = true;
  double source_gap_m = 0.0;            ///< from the last point of the source to its first; bridged when `closed`
  std::size_t points = 0, points_used = 0;
  std::size_t start_point = 1;          ///< point of the source, from 1, where the course begins
  std::size_t laps = 0;                 ///< whole laps found in the source; 0: driven once
  std::size_t laps_used = 1;
  std::optional<double> noise_m{};      ///< of the points across the course; none without points
  std::string noise_origin{};           ///< "measured from the points", "as given", ...
  bool of_segments = true;              ///< straights and arcs; not a line that bends evenly all along
  PointList source_points, line;        ///< for the picture, in the same plane; empty without points
  std::vector<std::string> notes;
};

/// Throws InputError for a source that cannot be used.
[[nodiscard]] ImportedCourse import_course(const std::string& path, const ImportOptions& options);

}  // namespace voltlap::plant
