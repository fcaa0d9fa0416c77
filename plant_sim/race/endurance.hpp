// SPDX-License-Identifier: Apache-2.0
// An endurance: driver, car and ECUs in lockstep on one bus, from the first tick after power-on to the last lap.
#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "core/parameters.hpp"
#include "io/bus/plant_bus.hpp"
#include "io/bus/frame_sink.hpp"
#include "io/bus/in_process_loop.hpp"
#include "race/driver/target.hpp"
#include "race/endurance_result.hpp"
#include "race/sensors/pedal_sensors.hpp"
#include "race/track/lap_solver.hpp"
#include "race/track/track.hpp"

namespace voltlap::plant {

class Pack;

/// Who sits in the car. A harness may take over pedals and switches from each of them.
enum class DriverKind {
  kLaps,   ///< powers up and drives the laps
  kStand,  ///< powers up and stands, pedals released
  kNobody, ///< the shutdown circuit is closed, and that is all
};

struct EnduranceOptions {
  VehicleParameters vehicle;
  Track track;                         ///< not used when `drive` is given
  std::optional<RecordedDrive> drive;  ///< a recorded drive instead of laps
  int laps = 27;
  LapStart lap_start = LapStart::kFlying;
  bool representative_cell = false;
  std::uint64_t seed = 1;
  PedalSensors pedal_sensors{};
  int steps_per_tick = 10;             ///< integration steps in a control period of 10 ms
  DriverKind driver = DriverKind::kLaps;
  std::optional<double> duration_s;    ///< ends then, finished; counted from power-on
  bool keep_going = false;             ///< what fails is noted and does not end the run
};

/// A moment of the run, at 10 Hz.
struct TimeSample {
  double time_s, distance_m;
  int lap;  ///< from 1
  double speed_mps, target_mps, accelerator, brake;
  double pack_current_a, pack_voltage_v, dc_link_v, phase_current_a;
  double discharge_limit_a, charge_limit_a;
  std::size_t limit_reason;  ///< that binds now, 0 none; see limit_reason_name
  double soc, bms_soc, battery_temperature_c, motor_temperature_c, front_rotor_c, rear_rotor_c;
  double course_m;         ///< along the line of the course since the start, all laps
  double lap_distance_m;   ///< of it, in this lap
  double power_w;          ///< at the pack's terminals, positive out of it
  double power_mean_w;     ///< of the last 500 ms, over the integration steps
  double longitudinal_mps2;
  double charge_drawn_ah;  ///< net, from the pack, since the car was ready to drive
  double lateral_mps2;     ///< v^2 times the course's curvature, positive to the right; NaN without, or by the clock
  const std::vector<double>* cell_voltage_v;
  const std::vector<double>* cell_temperature_c;
  const std::vector<double>* cell_soc;
  const Pack* pack = nullptr;  ///< as it is now
};

class EnduranceObserver : public FrameSink {
 public:
  virtual void on_sample(const TimeSample& sample) = 0;
  /// About 10 times a simulated second; the fraction is negative when the end is not known.
  virtual void on_progress(double fraction, double time_s) = 0;
  [[nodiscard]] virtual bool stop_requested() = 0;
};

/// As many laps as fit into the 22 km of the rules: 27 of Michigan 2015, 29 of 2014.
[[nodiscard]] int laps_of_endurance(const Track& track);

/// Throws InputError for options that contradict each other or a car that cannot drive the track; a run that fails on
/// the road is a result, with cause and time.
[[nodiscard]] EnduranceResult run_endurance(const EnduranceOptions& options, PlantBus& bus,
                                            EnduranceObserver& observer);
/// The same with control units in this process.
[[nodiscard]] EnduranceResult run_endurance(const EnduranceOptions& options, Ecus& ecus, EnduranceObserver& observer);

}  // namespace voltlap::plant
