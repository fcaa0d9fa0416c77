// SPDX-License-Identifier: Apache-2.0
// Quasi-steady-state lap: the fastest speed at every point of the course for a particle that corners on its tyres'
// friction, accelerates on the motor's curve and brakes at full pedal.
//
//   corner: v^2 / r <= a_y,max, and no wheel lifted                        Eq. 3.10-3.15
//   forward: m* a = min(tau(w) G eta / r, s mu N_driven) - resistance      Eq. 3.2-3.9
//   backward: m* a = -(brakes, none of them locking + resistance);  m* = m + I / r^2
// resistance: drag, rolling, climbing, cornering. s: what cornering leaves of the friction ellipse
// (car/vehicle/grip.hpp; the study uses a square). tau: the road's motor (car/powertrain/full_torque.hpp).
// Source: reference study, 2016, chapter 3.
#pragma once
#include <vector>

#include "core/parameters.hpp"
#include "race/track/track.hpp"

namespace voltlap::plant {

enum class LapStart {
  kFlying,    ///< periodic: the lap ends at the speed it began with
  kStanding,  ///< from rest
};

enum class LapPhase : unsigned char { kAccelerate, kBrake, kCorner };

/// Speed at the grid points of a lap; between two of them the acceleration is constant.
struct SpeedProfile {
  std::vector<double> distance_m;     ///< from 0 to the track's length
  std::vector<double> speed_mps;
  std::vector<double> time_s;         ///< since the start of the lap
  std::vector<LapPhase> phase;        ///< of the interval that begins at the point
  std::vector<double> curvature_per_m;  ///< of the interval that begins at the point
  std::vector<double> grade, head_wind_mps;  ///< of it, too

  [[nodiscard]] double lap_time_s() const { return time_s.back(); }
  [[nodiscard]] double length_m() const { return distance_m.back(); }
  [[nodiscard]] double max_speed_mps() const;
};

/// `step_m`: longest grid interval (segments are divided evenly). Throws InputError when the car cannot drive the
/// course.
[[nodiscard]] SpeedProfile solve_lap(const VehicleParameters& car, const Track& track, LapStart start,
                                     double step_m = 1.0);

/// Greatest cornering speed [m/s] at a curvature [1/m]; a very large number on a straight.
[[nodiscard]] double corner_speed(const VehicleParameters& car, double curvature_per_m, double head_wind_mps = 0.0);

}  // namespace voltlap::plant
