// SPDX-License-Identifier: Apache-2.0
#include "race/track/import/course_import.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "core/demand.hpp"
#include "core/errors.hpp"
#include "core/signal.hpp"
#include "race/track/import/centre_line.hpp"
#include "race/track/import/course_closing.hpp"
#include "race/track/import/laps.hpp"
#include "race/track/import/smooth_path.hpp"

namespace voltlap::plant {
namespace {

constexpr std::size_t kFewestPoints = 8;
constexpr double kStep_m = 0.25;            // between the nodes of the line
constexpr double kMostNodes = 20000.0;
constexpr double kShortest_m = 10.0, kLongest_m = 100e3;
constexpr double kSparse_m = 5.0;            // between points, beyond which their noise cannot be told from corners
constexpr double kSparseNoise_m = 0.1;      // then taken: how far a cone stands from where it was meant
constexpr double kLapReach_m = 6.0;         // a course's width and the drift of a GPS
constexpr double kGapBridged_m = 10.0;
constexpr double kStraightRadius_m = 2000.0;  // beyond it a bend is called straight
constexpr double kSamePlace_m = 1e-6;
constexpr double kTightest_m = 1.5;
constexpr double kBackwards = -0.2;         // cosine of the angle beyond which a step goes back

/// Points in order without repetitions of the one before.
PointList without_repetitions(const PointList& points, std::vector<std::string>& notes) {
  PointList kept;
  for (const PlanePoint& point : points) {
    if (kept.empty() || length(point - kept.back()) > kSamePlace_m) kept.push_back(point);
  }
  if (kept.size() > 1 && length(kept.back() - kept.front()) <= kSamePlace_m) kept.pop_back();
  if (kept.size() < points.size()) {
    notes.push_back(fmt::format("{} repeated points left out", points.size() - kept.size()));
  }
  return kept;
}

/// The path without the places that it stood at and went back to: points at least `apart_m` on, each ahead of the last.
PointList forward_only(const PointList& path, double apart_m, bool closed) {
  PointList kept{path.front()};
  PlanePoint heading{};
  for (const PlanePoint& point : path) {
    const PlanePoint step = point - kept.back();
    const double way = length(step);
    if (way < apart_m) continue;
    const bool backwards = way < 5.0 * apart_m && dot(step, heading) < kBackwards * way;
    if (backwards) continue;
    heading = (1.0 / way) * step;
    kept.push_back(point);
  }
  const double left = length(path.back() - kept.back());
  if (!closed && left > 0.0 && left < apart_m && dot(path.back() - kept.back(), heading) > 0.0) {
    kept.back() = path.back();  // an open course goes to its end
  }
  while (closed && kept.size() > 3 &&
         (length(kept.back() - kept.front()) < apart_m ||
          (length(kept.back() - kept.front()) < 5.0 * apart_m && dot(kept.front() - kept.back(), heading) < 0.0))) {
    kept.pop_back();
  }
  return kept;
}

/// The part [first, end) of the points that is one round of a closed course, smoothed as a ring.
PointList smooth_ring(const PointList& points) {
  const std::size_t n = points.size(), extra = std::min<std::size_t>(n / 3, 300);
  PointList ring(points.end() - static_cast<long>(extra), points.end());
  ring.insert(ring.end(), points.begin(), points.end());
  ring.insert(ring.end(), points.begin(), points.begin() + static_cast<long>(extra));
  const PointList smooth = smooth_path(ring).points;
  return {smooth.begin() + static_cast<long>(extra), smooth.begin() + static_cast<long>(extra + n)};
}

/// The lap with its ends joined: what they lie apart is shared out along it.
PointList joined(const PointList& path, const Lap& lap) {
  PointList ring;
  const PlanePoint apart = path[std::min(lap.end, path.size() - 1)] - path[lap.first];
  const double n = static_cast<double>(lap.end - lap.first);
  for (std::size_t i = lap.first; i < lap.end; ++i) {
    ring.push_back(path[i] - (static_cast<double>(i - lap.first) / n) * apart);
  }
  return ring;
}

class PointsImport {
 public:
  PointsImport(CourseSource source, const ImportOptions& options, ImportedCourse& course)
      : options_(options), course_(course), recorded_(std::move(source.points)),
        points_(without_repetitions(recorded_, course.notes)) {}

  void run(const std::string& path) {
    check(path);
    sparse_ = course_.kind == SourceKind::kGates || median_step() > kSparse_m;
    if (sparse_) smooth_.points = points_;
    else smooth_ = smooth_path(points_);
    scatter_m_ = smooth_.scatter_m;
    choose_laps();
    if (course_.laps == 0) judge_closure();
    fit();
  }

 private:
  void check(const std::string& path) const {
    if (points_.size() < kFewestPoints) {
      throw InputError(path, fmt::format("{} points", points_.size()),
                       fmt::format("{} or more that differ", kFewestPoints), "Record the course with more points");
    }
  }

  [[nodiscard]] double median_step() const {
    std::vector<double> steps;
    for (std::size_t i = 1; i < points_.size(); ++i) steps.push_back(length(points_[i] - points_[i - 1]));
    return median(steps);
  }

  void choose_laps() {
    if (options_.closure == Closure::kOpen) {
      course_.closed = false;
      use_ = points_;
      return;
    }
    const std::vector<Lap> laps = find_laps(smooth_.points, std::max(kLapReach_m, 4.0 * scatter_m_));
    course_.laps = laps.size();
    if (options_.lap && *options_.lap > std::max<std::size_t>(1, laps.size())) {
      throw InputError("--lap", fmt::format("{}", *options_.lap),
                       fmt::format("a lap of the {} found", laps.size()), "Choose another, or leave the flag out");
    }
    if (laps.empty()) {
      use_ = points_;
      return;
    }
    const std::size_t first = options_.lap ? *options_.lap - 1 : 0;
    const std::size_t end = options_.lap ? *options_.lap : laps.size();
    for (std::size_t k = first; k < end; ++k) {
      const std::size_t last = std::min(laps[k].end, points_.size());
      const auto of_lap = [&](std::size_t i) { return points_.begin() + static_cast<long>(i); };
      use_.insert(use_.end(), of_lap(laps[k].first), of_lap(last));
    }
    course_.laps_used = end - first;
    start_ = joined(smooth_.points, laps[first]);
    note_start(laps[first].first);
    course_.closed = true;
    const std::size_t again = std::min(laps[first].end, points_.size() - 1);
    course_.source_gap_m = length(smooth_.points[again] - smooth_.points[laps[first].first]);
  }

  /// Repeated points are counted again.
  void note_start(std::size_t kept) {
    std::size_t before = 0;
    PlanePoint last{};
    for (std::size_t i = 0; i < recorded_.size(); ++i) {
      if (i > 0 && length(recorded_[i] - last) <= kSamePlace_m) continue;
      last = recorded_[i];
      if (before++ != kept) continue;
      course_.start_point = i + 1;
      return;
    }
  }

  void judge_closure() {
    const double gap = length(points_.back() - points_.front());
    course_.source_gap_m = gap;
    if (options_.closure == Closure::kRecognised) {
      course_.closed = gap <= std::max({kGapBridged_m, 2.0 * median_step(), 4.0 * scatter_m_});
    } else {
      course_.closed = options_.closure == Closure::kClosed;
    }
    start_ = course_.closed && !sparse_ ? smooth_ring(points_) : smooth_.points;
  }

  void fit() {
    const double apart = std::clamp(3.0 * std::max(scatter_m_, options_.noise_m), 1.0, 3.0);
    const PointList forward = forward_only(start_, apart, course_.closed);
    const double length_m = forward.size() < 4 ? 0.0 : distances_along(forward, course_.closed).back();
    if (!(length_m >= kShortest_m && length_m <= kLongest_m)) {
      throw InputError("the points", fmt::format("a way of {:.1f} m", length_m),
                       fmt::format("{:.0f} m to {:.0f} km", kShortest_m, kLongest_m / 1000.0), "Check the unit");
    }
    const double step = std::max(kStep_m, length_m / kMostNodes);
    CentreLineOptions how;
    how.closed = course_.closed;
    how.noise_m = options_.noise_m;
    how.arcs = !sparse_;
    if (sparse_ && options_.noise_m < 0.0) how.noise_m = kSparseNoise_m;
    how.progress = [&](double share) {
      if (options_.progress) options_.progress("finding the corners", share);
    };
    const CentreLine line = fit_centre_line(evenly_spaced(forward, step, course_.closed), use_, how);
    for (const Arc& arc : line.arcs) {
      const bool straight = std::abs(arc.curvature_per_m) < 1.0 / kStraightRadius_m;
      course_.track.segments.push_back({arc.length_m, straight ? 0.0 : -arc.curvature_per_m});
    }
    if (course_.closed) course_.track.segments = closed_segments(course_.track.segments);
    course_.noise_m = line.noise_m;
    course_.noise_origin = options_.noise_m >= 0.0 ? "as given"
                           : sparse_               ? "taken, as so few points do not tell"
                                                   : "measured from the points";
    course_.points_used = line.points_used;
    course_.of_segments = line.of_segments;
    course_.line = line.nodes;
    course_.source_points = points_;
  }

  const ImportOptions& options_;
  ImportedCourse& course_;
  PointList recorded_, points_, use_, start_;
  SmoothPath smooth_;
  double scatter_m_ = 0.0;
  bool sparse_ = false;  ///< too far apart to tell noise from corners
};

void refuse_flags_of_points(const ImportOptions& options, SourceKind kind) {
  const auto refuse = [&](const char* flag) {
    throw InputError(flag, fmt::format("it with {}, which are taken as they stand", name_of(kind)),
                     "it with points, GPS or gates", "Leave the flag out");
  };
  if (options.noise_m >= 0.0) refuse("--noise");
  if (options.lap) refuse("--lap");
}

void turn_round(ImportedCourse& course, const ImportOptions& options) {
  auto& segments = course.track.segments;
  if (options.reversed) {
    std::reverse(segments.begin(), segments.end());
    for (Segment& segment : segments) segment.grade = segment.grade == 0.0 ? 0.0 : -segment.grade;
  }
  if (options.reversed != options.mirrored) {  // driven the other way a left corner is a right one
    for (Segment& segment : segments) {
      if (segment.curvature_per_m != 0.0) segment.curvature_per_m = -segment.curvature_per_m;
    }
  }
  if (options.reversed) std::reverse(course.line.begin(), course.line.end());
  if (options.mirrored) {
    for (PointList* points : {&course.line, &course.source_points}) {
      for (PlanePoint& point : *points) point.y_m = -point.y_m;
    }
  }
}

/// A corner that no car drives comes from points with a kink or a loop.
void note_kink(ImportedCourse& course) {
  const CourseSummary sum = summarise(course.track);
  if (sum.tightest_radius_m == 0.0 || sum.tightest_radius_m >= kTightest_m) return;
  course.notes.push_back(fmt::format(
      "a corner of {:.2f} m radius {:.0f} m behind the start is tighter than courses are: look at the source there{}",
      sum.tightest_radius_m, sum.tightest_at_m, course.noise_m ? ", or smooth with --noise" : ""));
}

void check_length(const Track& track, const std::string& path) {
  const double length = track.length_m();
  if (length >= kShortest_m && length <= kLongest_m) return;
  throw InputError(path, fmt::format("a course of {:g} m", length),
                   fmt::format("{:.0f} m to {:.0f} km", kShortest_m, kLongest_m / 1000.0), "Check the unit");
}

}  // namespace

ImportedCourse import_course(const std::string& path, const ImportOptions& options) {
  CourseSource source = read_course_source(path, options.source);
  ImportedCourse course;
  course.kind = source.kind;
  course.notes = source.notes;
  std::filesystem::path file(path);
  if (file.extension() == ".gz") file = file.stem();
  course.track.name = options.name.empty() ? file.stem().string() : options.name;
  if (source.points.empty()) {
    refuse_flags_of_points(options, source.kind);
    course.track.segments = std::move(source.segments);
    course.points = course.points_used = course.track.segments.size();
    course.laps_used = 1;
    const double gap = summarise(course.track).gap_m;
    course.source_gap_m = gap;
    course.closed = options.closure == Closure::kRecognised ? gap <= 0.05 * course.track.length_m()
                                                            : options.closure == Closure::kClosed;
  } else {
    course.points = source.points.size();
    PointsImport(std::move(source), options, course).run(path);
  }
  turn_round(course, options);
  check_length(course.track, path);
  note_kink(course);
  VOLTLAP_DEMAND(!course.track.segments.empty());
  return course;
}

}  // namespace voltlap::plant
