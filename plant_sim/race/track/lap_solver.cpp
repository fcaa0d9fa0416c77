// SPDX-License-Identifier: Apache-2.0
#include "race/track/lap_solver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "car/vehicle/aero.hpp"
#include "car/vehicle/brakes.hpp"
#include "car/vehicle/chassis.hpp"
#include "core/demand.hpp"
#include "core/errors.hpp"

namespace voltlap::plant {
namespace {

constexpr double kUnbounded = 1e3;  // m/s, stands for "no limit from cornering"

/// Forces of the particle model; everything that does not depend on speed is worked out once.
class Particle {
 public:
  explicit Particle(const VehicleParameters& car)
      : car_(car),
        effective_mass_(total_mass(car) +
                        car.powertrain.driveline_inertia_kg_m2 / (car.tyres.lap_radius_m * car.tyres.lap_radius_m)),
        wheel_per_motor_(car.powertrain.final_drive / car.tyres.lap_radius_m),
        rolling_(car.tyres.rolling_resistance * total_mass(car) * car.environment.gravity_mps2) {
    const BrakeTorques full = brake_torques(car.brakes, 1.0);
    brake_force_ = (full.front_nm + full.rear_nm) / car.tyres.lap_radius_m;
    const auto& rpm = car.motor.curve_speed_rpm;
    const auto& torque = car.motor.curve_torque_nm;
    const double top = rpm.back();
    for (std::size_t i = 0; i <= kCurvePoints; ++i) {
      const double at = top * static_cast<double>(i) / kCurvePoints;
      const auto above = std::upper_bound(rpm.begin() + 1, rpm.end() - 1, at);
      const auto k = static_cast<std::size_t>(above - rpm.begin());
      curve_[i] = torque[k - 1] + (torque[k] - torque[k - 1]) * (at - rpm[k - 1]) / (rpm[k] - rpm[k - 1]);
    }
    curve_per_speed_ = wheel_per_motor_ * 30.0 / M_PI / top * kCurvePoints;
  }

  /// Greatest acceleration, full pedal.
  [[nodiscard]] double max_acceleration(double v) const {
    const double place = v * curve_per_speed_;
    const auto i = static_cast<std::size_t>(std::min(place, static_cast<double>(kCurvePoints)));
    const double torque =
        i >= kCurvePoints ? 0.0 : curve_[i] + (curve_[i + 1] - curve_[i]) * (place - static_cast<double>(i));
    const double motor = torque * wheel_per_motor_ * car_.powertrain.driveline_efficiency;
    // Rear load rises with acceleration; the force at the edge of grip solves both at once: F = mu (N_0 + F h / L).
    const double rear_static = axle_loads(car_, 0.0, v).rear_n;
    const double lever = car_.tyres.friction * car_.vehicle.cg_height_m / car_.vehicle.wheelbase_m;
    const double grip = lever < 1.0 ? car_.tyres.friction * rear_static / (1.0 - lever) : motor;
    return (std::min(motor, grip) - resistance(v)) / effective_mass_;
  }
  /// Greatest deceleration, full brake, as a positive number.
  [[nodiscard]] double max_deceleration(double v) const {
    const double weight = total_mass(car_) * car_.environment.gravity_mps2 + downforce(car_, v);
    return (std::min(brake_force_, car_.tyres.friction * weight) + resistance(v)) / effective_mass_;
  }

 private:
  static constexpr std::size_t kCurvePoints = 512;
  [[nodiscard]] double resistance(double v) const { return drag_force(car_, v) + rolling_; }

  const VehicleParameters& car_;
  double effective_mass_, wheel_per_motor_, rolling_, brake_force_ = 0.0, curve_per_speed_ = 0.0;
  double curve_[kCurvePoints + 1] = {};
};

/// Speed [m/s] at which the drive force just meets the resistance: no straight is long enough to go faster.
double top_speed(const Particle& particle) {
  double low = 0.0, high = kUnbounded;
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (low + high);
    (particle.max_acceleration(middle) > 0.0 ? low : high) = middle;
  }
  return high;
}

/// Speed after `way` metres of acceleration a(v), by the midpoint rule on v^2.
template <class Acceleration>
double speed_after(double v, double way, const Acceleration& a) {
  const double half = std::max(0.0, v * v + a(v) * way);
  return std::sqrt(std::max(0.0, v * v + 2.0 * a(std::sqrt(half)) * way));
}

void lay_grid(const VehicleParameters& car, const Track& track, double step_m, SpeedProfile& p,
              std::vector<double>& limit) {
  double at = 0.0;
  for (const Segment& segment : track.segments) {
    const auto pieces = static_cast<std::size_t>(std::ceil(segment.length_m / step_m));
    const double corner = corner_speed(car, segment.curvature_per_m);
    for (std::size_t i = 0; i < pieces; ++i) {
      p.distance_m.push_back(at + segment.length_m * static_cast<double>(i) / static_cast<double>(pieces));
      p.curvature_per_m.push_back(segment.curvature_per_m);
      limit.push_back(corner);
    }
    at += segment.length_m;
  }
  VOLTLAP_DEMAND(!limit.empty());
  p.distance_m.push_back(at);
  p.curvature_per_m.push_back(p.curvature_per_m.back());
  limit.push_back(limit.back());
  // A point between two intervals obeys both.
  for (std::size_t i = limit.size() - 1; i-- > 1;) limit[i] = std::min(limit[i], limit[i - 1]);
}

/// A corner's centre must lie outside the car.
void check_corners(const VehicleParameters& car, const Track& track) {
  const double half_width = 0.5 * std::max(car.vehicle.track_front_m, car.vehicle.track_rear_m);
  for (const Segment& segment : track.segments) {
    const double radius = 1.0 / std::abs(segment.curvature_per_m);
    if (radius > half_width) continue;
    throw InputError(fmt::format("track {}, {}", track.name, segment.place),
                     fmt::format("a corner of {:g} m radius, which the car cannot drive", radius),
                     fmt::format("more than {:g} m, half the width between its wheels", half_width),
                     "Widen the corner");
  }
}

}  // namespace

double SpeedProfile::max_speed_mps() const { return *std::max_element(speed_mps.begin(), speed_mps.end()); }

double corner_speed(const VehicleParameters& car, double curvature_per_m) {
  const double c = std::abs(curvature_per_m);
  if (c == 0.0) return kUnbounded;
  const double m = total_mass(car);
  const double weight = m * car.environment.gravity_mps2;
  const double lift = downforce(car, 1.0);  // per (m/s)^2
  const double rear = car.vehicle.cg_rear_fraction;
  const auto speed_at = [](double constant, double per_v2) {
    return per_v2 > 0.0 ? std::sqrt(constant / per_v2) : kUnbounded;
  };
  const double grip = speed_at(car.tyres.friction * weight, m * c - car.tyres.friction * lift);
  const double front_lift =
      speed_at(weight * (1.0 - rear) / 2.0,
               m * (1.0 - rear) * c * car.vehicle.cg_height_m / car.vehicle.track_front_m - lift / 4.0);
  const double rear_lift =
      speed_at(weight * rear / 2.0, m * rear * c * car.vehicle.cg_height_m / car.vehicle.track_rear_m - lift / 4.0);
  return std::min({grip, front_lift, rear_lift, kUnbounded});
}

SpeedProfile solve_lap(const VehicleParameters& car, const Track& track, LapStart start, double step_m) {
  VOLTLAP_DEMAND(step_m > 0.0 && !track.segments.empty());
  check_corners(car, track);
  const Particle particle(car);
  SpeedProfile p;
  std::vector<double> v;
  lay_grid(car, track, step_m, p, v);
  const std::size_t last = v.size() - 1;
  if (!(particle.max_acceleration(0.0) > 0.0)) {
    throw InputError(fmt::format("car {} on track {}", car.name, track.name),
                     "a car that cannot drive: it does not move off",
                     "a drive force at standstill that exceeds the rolling resistance",
                     "Check motor.curve_torque_nm, powertrain.final_drive, tyres.* and vehicle.mass_kg");
  }

  const double most = top_speed(particle);
  for (double& limit : v) limit = std::min(limit, most);
  const bool periodic = start == LapStart::kFlying;
  if (periodic) v[0] = v[last] = std::min(v[0], v[last]);
  else v[0] = 0.0;
  // A periodic lap needs its passes twice: the first carries the speed at the line around once.
  for (int round = 0; round < (periodic ? 2 : 1); ++round) {
    for (std::size_t i = 0; i < last; ++i) {
      const double way = p.distance_m[i + 1] - p.distance_m[i];
      v[i + 1] = std::min(v[i + 1], speed_after(v[i], way, [&](double s) { return particle.max_acceleration(s); }));
    }
    if (periodic) v[0] = std::min(v[0], v[last]);
    for (std::size_t i = last; i-- > 0;) {
      const double way = p.distance_m[i + 1] - p.distance_m[i];
      v[i] = std::min(v[i], speed_after(v[i + 1], way, [&](double s) { return particle.max_deceleration(s); }));
    }
    if (periodic) v[last] = std::min(v[last], v[0]);
  }

  p.speed_mps = v;
  p.time_s.assign(v.size(), 0.0);
  p.phase.assign(v.size(), LapPhase::kCorner);
  for (std::size_t i = 0; i < last; ++i) {
    const double way = p.distance_m[i + 1] - p.distance_m[i];
    const double mean = 0.5 * (v[i] + v[i + 1]);
    if (!(mean > 1e-3)) {
      throw InputError(
          fmt::format("car {} on track {}", car.name, track.name),
          fmt::format("a car that cannot drive it: it stands still {:.1f} m after the start", p.distance_m[i]),
          "a speed above 0 everywhere", "Check motor.curve_torque_nm, tyres.friction and the track's corners");
    }
    p.time_s[i + 1] = p.time_s[i] + way / mean;
    const double change = v[i + 1] - v[i];
    if (std::abs(change) > 1e-9) p.phase[i] = change > 0.0 ? LapPhase::kAccelerate : LapPhase::kBrake;
  }
  p.phase[last] = p.phase[last - 1];
  VOLTLAP_DEMAND(all_finite(p.speed_mps) && std::is_sorted(p.time_s.begin(), p.time_s.end()));
  VOLTLAP_DEMAND(p.distance_m.size() == p.speed_mps.size() && p.curvature_per_m.size() == p.speed_mps.size());
  return p;
}

}  // namespace voltlap::plant
