// SPDX-License-Identifier: Apache-2.0
// A planted twofold slowdown, for the test of the comparison: the linker (--wrap) puts this between the workloads and
// solve_lap, and every lap is then solved twice. Only voltlap-benchmark-slowed has it.
#include "race/track/lap_solver.hpp"

using voltlap::plant::LapStart;
using voltlap::plant::SpeedProfile;
using voltlap::plant::Track;
using voltlap::plant::VehicleParameters;

// The names that --wrap asks for: __real_ is the product's function, __wrap_ takes its place.
SpeedProfile real_solve_lap(const VehicleParameters&, const Track&, LapStart,
                            double) __asm__("__real_" SOLVE_LAP_SYMBOL);
SpeedProfile solve_lap_twice(const VehicleParameters&, const Track&, LapStart,
                             double) __asm__("__wrap_" SOLVE_LAP_SYMBOL);

SpeedProfile solve_lap_twice(const VehicleParameters& car, const Track& track, LapStart start, double step_m) {
  const SpeedProfile first = real_solve_lap(car, track, start, step_m);
  return first.time_s.empty() ? first : real_solve_lap(car, track, start, step_m);
}
