// SPDX-License-Identifier: Apache-2.0
#include "race/driver/line_keeping.hpp"

#include <algorithm>
#include <cmath>

#include "car/vehicle/grip.hpp"
#include "core/demand.hpp"

namespace voltlap::plant {
namespace {

constexpr double kReturn_per_s = 1.2;       // how quickly a driver comes back to the line; assumed
constexpr double kEased_per_m = 0.15, kEasedMost = 0.3;  // of the speed, outside of the line; assumed
constexpr double kOver_mps = 0.1, kOpened_per_mps = 0.5, kOpenedMost = 0.2;  // of the steering, too fast; assumed
constexpr double kSlowest_mps = 0.5;        // below it a car goes where its wheels point
constexpr double kNearest_per_radius = 0.8; // a car does not come nearer to a corner's centre

}  // namespace

double LineKeeping::asked(double speed_mps, double curvature_per_m) const {
  const double line = speed_mps * speed_mps * curvature_per_m;
  if (offset_ == 0.0 && heading_ == 0.0) return line;
  const double nearer = 1.0 - std::min(curvature_per_m * offset_, kNearest_per_radius);
  return line / nearer - kReturn_per_s * kReturn_per_s * offset_ -
         2.0 * kReturn_per_s * speed_mps * std::sin(heading_);
}

Target LineKeeping::eased(Target target) const {
  const double outside = -std::copysign(offset_, offset_ * target.curvature_per_m);  // negative inside of the corner
  if (target.curvature_per_m == 0.0 || outside <= 0.0) return target;
  target.speed_mps *= 1.0 - std::min(kEasedMost, kEased_per_m * outside);
  return target;
}

Road LineKeeping::road(const Target& target, double speed_mps) {
  curvature_ = target.curvature_per_m;
  Road road{0.0, 1.0, target.grade, target.head_wind_mps};
  lateral_ = asked(speed_mps, curvature_);
  slides_ = false;
  if (lateral_ == 0.0) return road;

  const double airspeed = speed_mps + target.head_wind_mps;
  const double grip = lateral_grip(car_, airspeed);
  const double most = std::min(grip, lateral_lift(car_, airspeed));
  // Who is faster than planned opens the steering a little, for grip to brake with.
  const double over = std::max(0.0, speed_mps - target.speed_mps - kOver_mps);
  const double use = std::abs(speed_mps * speed_mps * curvature_) / most;
  const double opened = 1.0 - std::min(kOpenedMost, kOpened_per_mps * over);
  const double given = most * std::min(use > 1.0 ? 1.0 / use : 1.0, opened);
  if (std::abs(lateral_) > given) {
    lateral_ = std::copysign(given, lateral_);
    slides_ = true;
  }
  road.lateral_mps2 = lateral_;
  road.longitudinal_share = longitudinal_share(lateral_, grip);
  return road;
}

void LineKeeping::advance(double way_m, double step_s) {
  VOLTLAP_DEMAND(std::isfinite(way_m) && step_s > 0.0);
  if (!slides_ && offset_ == 0.0 && heading_ == 0.0) {
    distance_ += way_m;
    return;
  }
  const double nearer = 1.0 - std::min(curvature_ * offset_, kNearest_per_radius);
  const double along = way_m * std::cos(heading_) / nearer;
  const double speed = way_m / step_s;
  distance_ += along;
  offset_ += way_m * std::sin(heading_);
  if (std::abs(speed) > kSlowest_mps) {
    heading_ += lateral_ / speed * step_s - curvature_ * along;
  } else {
    heading_ = 0.0;
  }
  heading_ = std::clamp(heading_, -0.5 * M_PI, 0.5 * M_PI);
  // With grip to spare and close enough: the line again, to the last bit.
  constexpr double kNear_m = 1e-3, kNear_rad = 1e-3;
  if (!slides_ && std::abs(offset_) < kNear_m && std::abs(heading_) < kNear_rad) offset_ = heading_ = 0.0;
  VOLTLAP_DEMAND(std::isfinite(offset_) && std::isfinite(distance_));
}

}  // namespace voltlap::plant
