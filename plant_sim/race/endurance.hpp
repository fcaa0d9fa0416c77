// SPDX-License-Identifier: Apache-2.0
// An endurance: driver, car and ECUs in lockstep on one bus, from the first tick after power-on to the last lap.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "car/energy_ledger.hpp"
#include "core/parameters.hpp"
#include "io/bus/exchange.hpp"
#include "io/bus/frame_sink.hpp"
#include "io/bus/in_process_loop.hpp"
#include "race/driver/target.hpp"
#include "race/loss_watch.hpp"
#include "race/track/lap_solver.hpp"
#include "race/track/track.hpp"

namespace voltlap::plant {

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
  int steps_per_tick = 10;             ///< integration steps in a control period of 10 ms
  DriverKind driver = DriverKind::kLaps;
  std::optional<double> duration_s;    ///< ends then, finished; counted from power-on
  bool keep_going = false;             ///< what fails is noted and does not end the run
};

/// Why the driver got less than asked for; the first nine are the BMS's reasons, by their numbers in car.dbc.
inline constexpr std::size_t kLimitReasons = 12;
[[nodiscard]] const char* limit_reason_name(std::size_t reason);

/// A moment of the run, at 10 Hz.
struct TimeSample {
  double time_s, distance_m;
  int lap;  ///< from 1
  double speed_mps, target_mps, accelerator, brake;
  double pack_current_a, pack_voltage_v, dc_link_v, phase_current_a;
  double discharge_limit_a, charge_limit_a;
  std::size_t limit_reason;  ///< that binds now, 0 none; see limit_reason_name
  double soc, bms_soc, battery_temperature_c, motor_temperature_c, front_rotor_c, rear_rotor_c;
  const std::vector<double>* cell_voltage_v;
  const std::vector<double>* cell_temperature_c;
};

class EnduranceObserver : public FrameSink {
 public:
  virtual void on_sample(const TimeSample& sample) = 0;
  /// About 10 times a simulated second; the fraction is negative when the end is not known.
  virtual void on_progress(double fraction, double time_s) = 0;
  [[nodiscard]] virtual bool stop_requested() = 0;
};

struct LapRow {
  int lap;
  double time_s, energy_kwh, end_soc_pct, ledger_error_pct;
};

/// When each extreme of the result was first reached [s of the race].
struct ExtremeTimes {
  double battery_current_s = 0.0, speed_s = 0.0, pack_voltage_s = 0.0, cell_voltage_s = 0.0;
  double battery_temp_s = 0.0, motor_temp_s = 0.0;
};

struct EnduranceResult {
  bool finished = false;
  bool stopped = false;  ///< it was interrupted
  double failure_time_s = 0.0;
  std::string failure_cause;
  double end_soc_pct = 0.0, max_battery_temp_c = 0.0, total_time_s = 0.0, max_battery_current_a = 0.0;
  double min_pack_voltage_v = 0.0, min_cell_voltage_v = 0.0;
  int min_cell = 0;  ///< from 1, where the lowest cell voltage was seen
  double max_speed_mps = 0.0, distance_m = 0.0;
  int laps = 0;  ///< completed
  double energy_out_kwh = 0.0;
  double energy_ledger_error_pct = 0.0;  ///< worst lap
  double charge_balance_error_pct = 0.0;  ///< current integrated against SOC times capacity
  double bms_soc_error_pct = 0.0;  ///< largest difference of the firmware's SOC from the plant's
  double max_motor_temp_c = 0.0;
  ExtremeTimes extreme_times;
  std::array<double, kLimitReasons> limit_active_s{};
  std::vector<LapRow> lap_rows;
  std::vector<LostNodeRow> lost_nodes;
  EnergyLedger ledger;
  std::uint32_t ticks = 0;
  std::uint64_t frames = 0;
  std::uint32_t frames_in_tick_max = 0;
};

/// As many laps as fit into the 22 km of the rules: 27 of Michigan 2015, 29 of 2014.
[[nodiscard]] int laps_of_endurance(const Track& track);

/// Throws InputError for options that contradict each other or a car that cannot drive the track; a run that fails on
/// the road is a result, with cause and time.
[[nodiscard]] EnduranceResult run_endurance(const EnduranceOptions& options, Exchange& bus, EnduranceObserver& observer);
/// The same with control units in this process.
[[nodiscard]] EnduranceResult run_endurance(const EnduranceOptions& options, Ecus& ecus, EnduranceObserver& observer);

}  // namespace voltlap::plant
