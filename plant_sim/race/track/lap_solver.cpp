// SPDX-License-Identifier: Apache-2.0
#include "race/track/lap_solver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "car/powertrain/driveline.hpp"
#include "car/powertrain/full_torque.hpp"
#include "car/vehicle/aero.hpp"
#include "car/vehicle/brakes.hpp"
#include "car/vehicle/chassis.hpp"
#include "car/vehicle/cornering.hpp"
#include "car/vehicle/grip.hpp"
#include "core/demand.hpp"
#include "core/errors.hpp"

namespace voltlap::plant {
namespace {

constexpr double kConstant_mps2 = 0.05;  // less is a corner at its speed, not an acceleration
constexpr double kUnbounded = 1e3;  // m/s, stands for "no limit from cornering"

/// The road of one interval of the grid.
struct RoadPiece {
  double curvature_per_m, grade, head_wind_mps;
};

/// Forces of the particle model; what does not depend on speed is worked out once.
class Particle {
 public:
  explicit Particle(const VehicleParameters& car)
      : car_(car),
        motor_(car),
        mass_(total_mass(car)),
        effective_mass_(mass_ + driven_inertia(car) / (car.tyres.lap_radius_m * car.tyres.lap_radius_m)),
        wheel_per_motor_(car.powertrain.final_drive / car.tyres.lap_radius_m),
        rolling_(car.tyres.rolling_resistance * mass_ * car.environment.gravity_mps2) {
    const BrakeTorques full = brake_torques(car.brakes, 1.0);
    brake_force_ = (full.front_nm + full.rear_nm) / car.tyres.lap_radius_m;
  }

  /// Greatest acceleration, full pedal.
  [[nodiscard]] double max_acceleration(double v, const RoadPiece& road) const {
    const double resistance = this->resistance(v, road);
    const double grip = drive_grip(car_, v + road.head_wind_mps, share(v, road), resistance);
    return (std::min(motor_force(v), grip) - resistance) / effective_mass_;
  }
  /// The same with tyres that hold all of it.
  [[nodiscard]] double motor_acceleration(double v, const RoadPiece& road) const {
    return (motor_force(v) - resistance(v, road)) / effective_mass_;
  }
  /// Greatest deceleration, as a positive number: full pedal, or the pedal at which the first axle would lock.
  [[nodiscard]] double max_deceleration(double v, const RoadPiece& road) const {
    const double resistance = this->resistance(v, road), radius = car_.tyres.lap_radius_m;
    const CoastingDrag drag = coasting_drag(car_, v, radius);
    const double pedal = locking_pedal(car_, v + road.head_wind_mps, share(v, road), resistance, radius, drag);
    return (pedal * brake_force_ + (drag.sum_n() + resistance)) / effective_mass_;
  }

 private:
  [[nodiscard]] double resistance(double v, const RoadPiece& road) const {
    return drag_force(car_, v + road.head_wind_mps) + rolling_ + cornering_drag(car_, v * v * road.curvature_per_m) +
           climbing_force(car_, road.grade);
  }
  [[nodiscard]] double motor_force(double v) const {
    const double torque = motor_.torque_nm(v * wheel_per_motor_), efficiency = car_.powertrain.driveline_efficiency;
    return torque * wheel_per_motor_ * (torque >= 0.0 ? efficiency : 1.0 / efficiency);
  }
  [[nodiscard]] double share(double v, const RoadPiece& road) const {
    if (road.curvature_per_m == 0.0) return 1.0;
    return longitudinal_share(v * v * road.curvature_per_m, lateral_grip(car_, v + road.head_wind_mps));
  }

  const VehicleParameters& car_;
  FullTorque motor_;
  double mass_, effective_mass_, wheel_per_motor_, rolling_, brake_force_ = 0.0;
};

/// Speed [m/s] at which the drive force just meets the resistance: no road is long enough to go faster.
double top_speed(const Particle& particle, const RoadPiece& road) {
  double low = 0.0, high = kUnbounded;
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (low + high);
    (particle.max_acceleration(middle, road) > 0.0 ? low : high) = middle;
  }
  return high;
}

/// Of the straight on which the car is fastest, whatever the grades and winds of a course are.
double top_speed_anywhere(const Particle& particle, const SpeedProfile& p) {
  const auto fewest = [](const std::vector<double>& values) { return *std::min_element(values.begin(), values.end()); };
  return top_speed(particle, {0.0, fewest(p.grade), fewest(p.head_wind_mps)});
}

/// Speed after `way` metres of acceleration a(v), by the midpoint rule on v^2.
template <class Acceleration>
double speed_after(double v, double way, const Acceleration& a) {
  const double half = std::max(0.0, v * v + a(v) * way);
  return std::sqrt(std::max(0.0, v * v + 2.0 * a(std::sqrt(half)) * way));
}

/// The same towards a speed at which forces balance. It is come near to and never crossed: a low gear's motor holds it
/// so hard that a step across would end at a standstill.
template <class Acceleration>
double speed_near_balance(double v, double way, const Acceleration& a) {
  const double at_start = a(v), half = std::sqrt(std::max(0.0, v * v + at_start * way));
  const double far = at_start * a(half) < 0.0 ? half : speed_after(v, way, a);
  if (at_start * a(far) >= 0.0) return far;
  double near = v, beyond = far;
  for (int k = 0; k < 40; ++k) {
    const double between = 0.5 * (near + beyond);
    (at_start * a(between) > 0.0 ? near : beyond) = between;
  }
  return near;
}

/// Speed after `way` metres of full pedal. Where more than the motor ends the acceleration the tyres hold a corner at
/// its speed.
double full_pedal(const Particle& particle, double v, double way, const RoadPiece& road) {
  const double at_start = particle.max_acceleration(v, road);
  const double middle = std::sqrt(std::max(0.0, v * v + at_start * way));
  const double at_middle = particle.max_acceleration(middle, road);
  if (at_start >= 0.0 && at_middle >= 0.0) return std::sqrt(v * v + 2.0 * at_middle * way);
  return speed_near_balance(v, way, [&](double s) { return particle.motor_acceleration(s, road); });
}

void lay_grid(const VehicleParameters& car, const Track& track, double step_m, SpeedProfile& p,
              std::vector<double>& limit) {
  double at = 0.0, heading = 0.0;  // to the right, from the direction of the start
  const double wind = car.environment.wind_mps, wind_from = car.environment.wind_from_deg * M_PI / 180.0;
  for (const Segment& segment : track.segments) {
    const auto pieces = static_cast<std::size_t>(std::ceil(segment.length_m / step_m));
    const double length = segment.length_m / static_cast<double>(pieces);
    double corner = corner_speed(car, segment.curvature_per_m);
    for (std::size_t i = 0; i < pieces; ++i) {
      const double middle = heading + segment.curvature_per_m * length * (static_cast<double>(i) + 0.5);
      const double head_wind = wind > 0.0 ? wind * std::cos(wind_from - middle) : 0.0;
      if (wind > 0.0) corner = corner_speed(car, segment.curvature_per_m, head_wind);
      p.distance_m.push_back(at + segment.length_m * static_cast<double>(i) / static_cast<double>(pieces));
      p.curvature_per_m.push_back(segment.curvature_per_m);
      p.grade.push_back(segment.grade);
      p.head_wind_mps.push_back(head_wind);
      limit.push_back(corner);
    }
    at += segment.length_m;
    heading += segment.curvature_per_m * segment.length_m;
  }
  VOLTLAP_DEMAND(!limit.empty());
  p.distance_m.push_back(at);
  for (std::vector<double>* of_interval : {&p.curvature_per_m, &p.grade, &p.head_wind_mps, &limit}) {
    of_interval->push_back(of_interval->back());
  }
  // A point between two intervals obeys both.
  for (std::size_t i = limit.size() - 1; i-- > 1;) limit[i] = std::min(limit[i], limit[i - 1]);
}

RoadPiece road(const SpeedProfile& p, std::size_t i) {
  return {p.curvature_per_m[i], p.grade[i], p.head_wind_mps[i]};
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

double corner_speed(const VehicleParameters& car, double curvature_per_m, double head_wind_mps) {
  const double c = std::abs(curvature_per_m);
  if (c == 0.0) return kUnbounded;
  const auto held = [&](double v) {
    const double airspeed = v + head_wind_mps;
    return std::min(lateral_grip(car, airspeed), lateral_lift(car, airspeed)) >= v * v * c;
  };
  if (held(kUnbounded)) return kUnbounded;
  if (head_wind_mps == 0.0) {
    // Each limit is a + b v^2, so that its speed has a closed form; the least of them is no such line.
    const auto speed_at = [c](double still, double at_one) {
      return c > at_one - still ? std::sqrt(still / (c - (at_one - still))) : kUnbounded;
    };
    const AxleLift still = axle_lift(car, 0.0), at_one = axle_lift(car, 1.0);
    return std::min({speed_at(lateral_grip(car, 0.0), lateral_grip(car, 1.0)),
                     speed_at(still.front_mps2, at_one.front_mps2), speed_at(still.rear_mps2, at_one.rear_mps2),
                     kUnbounded});
  }
  double low = 0.0, high = kUnbounded;
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (low + high);
    (held(middle) ? low : high) = middle;
  }
  return low;
}

SpeedProfile solve_lap(const VehicleParameters& car, const Track& track, LapStart start, double step_m) {
  VOLTLAP_DEMAND(step_m > 0.0 && !track.segments.empty());
  check_corners(car, track);
  const Particle particle(car);
  SpeedProfile p;
  std::vector<double> v;
  lay_grid(car, track, step_m, p, v);
  const std::size_t last = v.size() - 1;
  if (!(particle.max_acceleration(0.0, road(p, 0)) > 0.0)) {
    const double pack_w = FullTorque(car).bus_power_max_w();
    const bool starved = pack_w <= car.low_voltage.power_w;
    throw InputError(
        fmt::format("car {} on track {}", car.name, track.name), "a car that cannot drive: it does not move off",
        starved ? fmt::format("more than the {:.0f} W of low_voltage.power_w from the pack, which may give {:.0f} W",
                              car.low_voltage.power_w, pack_w)
                : "a drive force at standstill that exceeds the rolling resistance",
        starved ? "Check bms.discharge_current_max_a, bms.cell_voltage_min_v, master.power_max_kw and battery.*"
                : "Check motor.*, inverter.current_max_a, powertrain.final_drive, tyres.* and vehicle.mass_kg");
  }

  const double most = top_speed_anywhere(particle, p);
  for (double& limit : v) limit = std::min(limit, most);
  const bool periodic = start == LapStart::kFlying;
  if (periodic) v[0] = v[last] = std::min(v[0], v[last]);
  else v[0] = 0.0;
  // A periodic lap needs its passes twice: the first carries the speed at the line around once.
  for (int round = 0; round < (periodic ? 2 : 1); ++round) {
    for (std::size_t i = 0; i < last; ++i) {
      const double way = p.distance_m[i + 1] - p.distance_m[i];
      v[i + 1] = std::min(v[i + 1], full_pedal(particle, v[i], way, road(p, i)));
    }
    if (periodic) v[0] = std::min(v[0], v[last]);
    for (std::size_t i = last; i-- > 0;) {
      const double way = p.distance_m[i + 1] - p.distance_m[i];
      const auto backward = [&](double s) { return particle.max_deceleration(s, road(p, i)); };
      v[i] = std::min(v[i], speed_after(v[i + 1], way, backward));
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
          "a speed above 0 everywhere", "Check motor.curve_torque_nm, tyres.pacejka_d and the track's corners");
    }
    p.time_s[i + 1] = p.time_s[i] + way / mean;
    const double acceleration = (v[i + 1] - v[i]) * mean / way;
    if (std::abs(acceleration) > kConstant_mps2) {
      p.phase[i] = acceleration > 0.0 ? LapPhase::kAccelerate : LapPhase::kBrake;
    }
  }
  p.phase[last] = p.phase[last - 1];
  VOLTLAP_DEMAND(all_finite(p.speed_mps) && std::is_sorted(p.time_s.begin(), p.time_s.end()));
  VOLTLAP_DEMAND(p.distance_m.size() == p.speed_mps.size() && p.curvature_per_m.size() == p.speed_mps.size());
  return p;
}

}  // namespace voltlap::plant
