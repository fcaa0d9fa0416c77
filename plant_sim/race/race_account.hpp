// SPDX-License-Identifier: Apache-2.0
// The books of a race: extremes by the integration step, limits and temperatures by the tick, laps with their energy,
// and the balances at the end.
#pragma once
#include "car/car.hpp"
#include "race/actuators/command_receiver.hpp"
#include "race/endurance_result.hpp"

namespace voltlap::plant {

/// Writes into a result that it does not own. Times are seconds since the car became ready to drive.
class RaceAccount {
 public:
  RaceAccount(EnduranceResult& result, const Car& car);

  /// The car is ready to drive: laps and energy count from here.
  void open(const Car& car);
  /// After an integration step.
  void note_step(const Car& car, double time_s);
  /// After a control period of `tick_s`, in which a limit bound for `limit_reason` (0: none did).
  void note_tick(const Car& car, const CommandReceiver& ecus, std::size_t limit_reason, double time_s, double tick_s);
  /// Writes the laps down that were completed until now; `laps_done` counts from the start.
  void close_laps(const Car& car, int laps_done, double time_s);
  /// The end of the run, whether or not it was opened.
  void close(const Car& car);

  [[nodiscard]] double lap_start_s() const { return lap_start_s_; }

 private:
  EnduranceResult& result_;
  double initial_soc_;
  bool open_ = false;
  EnergyLedger start_ledger_, lap_ledger_;
  double start_energy_j_ = 0.0, lap_energy_j_ = 0.0, lap_start_s_ = 0.0;
};

}  // namespace voltlap::plant
