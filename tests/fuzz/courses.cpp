// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <filesystem>
#include <fstream>

#include "core/demand.hpp"
#include "core/errors.hpp"
#include "core/parameter_file.hpp"
#include "fuzz/target.hpp"
#include "race/driver/target.hpp"
#include "race/report/run_comparison.hpp"
#include "race/track/import/course_import.hpp"
#include "race/track/import/course_picture.hpp"

namespace voltlap::plant {
namespace {

void check(const Track& track) {
  VOLTLAP_DEMAND(!track.segments.empty() && std::isfinite(track.length_m()) && track.length_m() > 0.0);
  for (const Segment& segment : track.segments) {
    VOLTLAP_DEMAND(segment.length_m >= 0.0 && std::isfinite(segment.curvature_per_m) && std::isfinite(segment.grade));
  }
  const CourseSummary sum = summarise(track);
  VOLTLAP_DEMAND(std::isfinite(sum.gap_m) && std::isfinite(sum.turned_deg) && std::isfinite(sum.climb_m));
}

/// What a course is written as is read as the same course.
void read_back(const Track& track, const std::string& path) {
  const std::string again = (std::filesystem::path(path).parent_path() / "again.csv").string();
  std::ofstream(again, std::ios::trunc) << course_file_text(track, "");
  const Track other = load_track(again);
  VOLTLAP_DEMAND(other.segments.size() == track.segments.size());
  for (std::size_t k = 0; k < track.segments.size(); ++k) {
    VOLTLAP_DEMAND(other.segments[k].length_m == track.segments[k].length_m);
    const double curvature = track.segments[k].curvature_per_m, read = other.segments[k].curvature_per_m;
    VOLTLAP_DEMAND(std::abs(read - curvature) <= 4e-16 * std::abs(curvature));
  }
}

void import(const std::string& path, ImportOptions options) {
  const ImportedCourse course = import_course(path, options);
  check(course.track);
  read_back(course.track, path);
  VOLTLAP_DEMAND(!course_picture(course.track, course.line, course.source_points, "a course").empty());
}

void check(const CourseSource& source) {
  VOLTLAP_DEMAND(!source.points.empty() || !source.segments.empty());
  for (const PlanePoint point : source.points) VOLTLAP_DEMAND(std::isfinite(point.x_m) && std::isfinite(point.y_m));
  for (const Segment& segment : source.segments) VOLTLAP_DEMAND(std::isfinite(segment.length_m));
}

}  // namespace

void read_track(const std::string& path) {
  const Track track = load_track(path);
  check(track);
}

void read_course(const std::string& path) { check(read_course_source(path, {{}, 1.0})); }

void read_gpx_course(const std::string& path) { check(read_course_source(path, {})); }

void import_small_course(const std::string& path) {
  ImportOptions options;
  options.source.metres_per_unit = 1.0;
  import(path, options);
}

void read_drive(const std::string& path) {
  const RecordedDrive drive = load_drive(path);
  VOLTLAP_DEMAND(all_finite(drive.time_s) && std::isfinite(drive.length_m()));
  TargetCursor cursor = TargetCursor::recorded(drive, VehicleParameters{}.driver);
  for (double part = 0.0; part <= 1.0; part += 0.125) {
    const Target target = cursor.at(part * drive.duration_s(), 0.0);
    VOLTLAP_DEMAND(std::isfinite(target.speed_mps) && std::isfinite(target.slope_mps2));
  }
}

void read_run(const std::string& path) {
  const std::string other = (std::filesystem::path(path).parent_path() / "other.json").string();
  std::filesystem::copy_file(path, other, std::filesystem::copy_options::overwrite_existing);
  const RunComparison comparison = compare_runs({path, other});
  VOLTLAP_DEMAND(!comparison_text(comparison).empty() && !comparison_json(comparison).empty());
  VOLTLAP_DEMAND(!comparison_page(comparison).empty());
}

}  // namespace voltlap::plant
