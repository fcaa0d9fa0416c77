// SPDX-License-Identifier: Apache-2.0
// What the driver tries to follow: a target speed with the pedals of its events (reference study, 2016, sections 3.5,
// 4.2), by position for flying laps, by time for the tiled trace from rest and for a recorded drive.
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "race/track/lap_solver.hpp"

namespace voltlap::plant {

struct Target {
  double speed_mps = 0.0;
  double slope_mps2 = 0.0;       ///< time derivative of the target speed
  double accelerator_base = 0.0; ///< first guess of the pedal, 0..1
  double brake_base = 0.0;
  double curvature_per_m = 0.0;  ///< of the line, where the driver follows one; positive turns right
  double grade = 0.0, head_wind_mps = 0.0;
};

/// A recorded or prescribed drive: speed over time, and the pedals where they were recorded.
struct RecordedDrive {
  std::string name;
  std::vector<double> time_s, speed_mps;
  std::vector<double> accelerator, brake;  ///< empty, or as long as time_s

  [[nodiscard]] double duration_s() const { return time_s.back(); }
  [[nodiscard]] double length_m() const;
};

/// Reads `time_s,speed_mps[,accelerator,brake]`. Time is shifted to begin at 0. Throws InputError with file and line.
[[nodiscard]] RecordedDrive load_drive(const std::string& path);

/// Cursor over one source of targets. Positions and times never run back far, so the search is a short walk.
class TargetCursor {
 public:
  /// Flying laps: target by position, periodic.
  static TargetCursor by_position(const SpeedProfile& lap, const DriverSection& driver);
  /// One lap from rest, tiled in time.
  static TargetCursor by_time(const SpeedProfile& lap, const DriverSection& driver);
  /// A recorded drive, once.
  static TargetCursor recorded(const RecordedDrive& drive, const DriverSection& driver);

  [[nodiscard]] Target at(double time_s, double distance_m);

 private:
  struct Point {
    double x, speed, slope, accelerator, brake;  // slope: dv/dx
    double curvature = 0.0, grade = 0.0, head_wind = 0.0;
  };
  enum class Axis { kPosition, kTime };

  TargetCursor(Axis axis, bool periodic) : axis_(axis), periodic_(periodic) {}
  void close(double end_x);

  Axis axis_;
  bool periodic_;
  std::vector<Point> points_;
  double length_ = 0.0;
  std::size_t index_ = 0;
};

}  // namespace voltlap::plant
