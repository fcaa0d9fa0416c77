// SPDX-License-Identifier: Apache-2.0
#include "race/driver/target.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include <fmt/format.h>

#include "core/demand.hpp"
#include "core/errors.hpp"
#include "io/table_file.hpp"

namespace voltlap::plant {
namespace {

/// Pedals of an event: full acceleration, full braking, constant speed.
std::pair<double, double> event_pedals(const DriverSection& driver, LapPhase phase) {
  switch (phase) {
    case LapPhase::kAccelerate: return {driver.accelerate_pedal, 0.0};
    case LapPhase::kBrake: return {0.0, driver.brake_pedal};
    case LapPhase::kCorner: break;
  }
  return {driver.corner_pedal, 0.0};
}

LapPhase phase_of(double acceleration) {
  constexpr double kConstant = 0.05;  // m/s2; recordings are never exactly constant
  if (acceleration > kConstant) return LapPhase::kAccelerate;
  return acceleration < -kConstant ? LapPhase::kBrake : LapPhase::kCorner;
}

double pedal_at(const InputTable& table, std::size_t row, const char* column) {
  const double pedal = table.number(row, column);
  if (pedal < 0.0 || pedal > 1.0) {
    throw InputError(fmt::format("{}, {}", table.place(row), column), fmt::format("{}", pedal), "a pedal from 0 to 1",
                     "Correct the value; percent must be divided by 100");
  }
  return pedal;
}

}  // namespace

double RecordedDrive::length_m() const {
  double sum = 0.0;
  for (std::size_t i = 1; i < time_s.size(); ++i)
    sum += 0.5 * (speed_mps[i] + speed_mps[i - 1]) * (time_s[i] - time_s[i - 1]);
  return sum;
}

RecordedDrive load_drive(const std::string& path) {
  const InputTable table(path);
  RecordedDrive drive{std::filesystem::path(path).stem().string(), {}, {}, {}, {}};
  const bool pedals = table.has("accelerator") || table.has("brake");
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const double time = table.number(row, "time_s") - table.number(0, "time_s");
    if (row > 0 && !(time > drive.time_s.back())) {
      throw InputError(table.place(row) + ", time_s",
                       fmt::format("{} after {}", table.number(row, "time_s"), table.number(row - 1, "time_s")),
                       "a time that increases from row to row", "Sort the rows and remove duplicates");
    }
    const double speed = table.number(row, "speed_mps");
    if (speed < 0.0 || speed > 150.0) {
      throw InputError(table.place(row) + ", speed_mps", fmt::format("{}", speed), "0 to 150 m/s",
                       "Correct the speed; km/h must be divided by 3.6");
    }
    drive.time_s.push_back(time);
    drive.speed_mps.push_back(speed);
    if (pedals) {
      drive.accelerator.push_back(pedal_at(table, row, "accelerator"));
      drive.brake.push_back(pedal_at(table, row, "brake"));
    }
  }
  if (drive.time_s.size() < 2) {
    throw InputError(path, "one row", "a drive of two or more", "Add rows");
  }
  VOLTLAP_DEMAND(increasing(drive.time_s) && all_finite(drive.speed_mps));
  VOLTLAP_DEMAND(drive.accelerator.size() == drive.brake.size());
  return drive;
}

void TargetCursor::close(double end_x) {
  VOLTLAP_DEMAND(points_.size() >= 2 && end_x > 0.0);
  length_ = end_x;
  for (std::size_t i = 0; i + 1 < points_.size(); ++i) {
    points_[i].slope = (points_[i + 1].speed - points_[i].speed) / (points_[i + 1].x - points_[i].x);
  }
}

TargetCursor TargetCursor::by_position(const SpeedProfile& lap, const DriverSection& driver) {
  TargetCursor cursor(Axis::kPosition, true);
  for (std::size_t i = 0; i < lap.distance_m.size(); ++i) {
    const auto [accelerator, brake] = event_pedals(driver, lap.phase[i]);
    cursor.points_.push_back({lap.distance_m[i], lap.speed_mps[i], 0.0, accelerator, brake, lap.curvature_per_m[i],
                              lap.grade[i], lap.head_wind_mps[i]});
  }
  cursor.close(lap.length_m());
  return cursor;
}

TargetCursor TargetCursor::by_time(const SpeedProfile& lap, const DriverSection& driver) {
  TargetCursor cursor(Axis::kTime, true);
  for (std::size_t i = 0; i < lap.time_s.size(); ++i) {
    const auto [accelerator, brake] = event_pedals(driver, lap.phase[i]);
    // A trace in time does not know where on the course the car is: no line to keep.
    cursor.points_.push_back({lap.time_s[i], lap.speed_mps[i], 0.0, accelerator, brake, 0.0, lap.grade[i],
                              lap.head_wind_mps[i]});
  }
  cursor.close(lap.lap_time_s());
  return cursor;
}

TargetCursor TargetCursor::recorded(const RecordedDrive& drive, const DriverSection& driver) {
  TargetCursor cursor(Axis::kTime, false);
  for (std::size_t i = 0; i < drive.time_s.size(); ++i) {
    cursor.points_.push_back({drive.time_s[i], drive.speed_mps[i], 0.0, 0.0, 0.0});
  }
  cursor.close(drive.duration_s());
  for (std::size_t i = 0; i < drive.time_s.size(); ++i) {
    auto& point = cursor.points_[i];
    std::tie(point.accelerator, point.brake) =
        drive.accelerator.empty() ? event_pedals(driver, phase_of(point.slope))
                                  : std::pair{drive.accelerator[i], drive.brake[i]};
  }
  return cursor;
}

Target TargetCursor::at(double time_s, double distance_m) {
  double x = axis_ == Axis::kPosition ? distance_m : time_s;
  x = periodic_ ? x - length_ * std::floor(x / length_) : std::clamp(x, 0.0, length_);
  if (x < points_[index_].x) index_ = 0;
  while (index_ + 2 < points_.size() && x >= points_[index_ + 1].x) ++index_;
  const Point& p = points_[index_];
  const double speed = p.speed + p.slope * (x - p.x);
  return {speed, axis_ == Axis::kPosition ? p.slope * speed : p.slope, p.accelerator, p.brake, p.curvature,
          p.grade, p.head_wind};
}

}  // namespace voltlap::plant
