// SPDX-License-Identifier: Apache-2.0
// The books of a race: extremes by the integration step, limits and temperatures by the tick, laps with their energy,
// and the balances at the end.
#pragma once
#include <array>
#include <cstddef>

#include "car/car.hpp"
#include "race/actuators/command_receiver.hpp"
#include "race/endurance_result.hpp"

namespace voltlap::plant {

/// Mean power over the last 500 ms, from the energy after each control period: the rules' measure of 80 kW
/// (Formula SAE EV.3.3). Before the start the car stood and took nothing.
class MovingPower {
 public:
  static constexpr double kWindow_s = 0.5;
  static constexpr std::size_t kTicks = 50;

  void open(double energy_j) { energy_j_.fill(energy_j); }
  /// The energy a control period later; returns the mean [W].
  double advance(double energy_j) {
    const double mean = (energy_j - energy_j_[oldest_]) / kWindow_s;
    energy_j_[oldest_] = energy_j;
    oldest_ = (oldest_ + 1) % kTicks;
    return mean;
  }

 private:
  std::array<double, kTicks> energy_j_{};
  std::size_t oldest_ = 0;
};

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
  [[nodiscard]] double power_mean_w() const { return power_mean_w_; }

 private:
  void note_beyond(const Car& car, const CommandReceiver& ecus, double tick_s);

  EnduranceResult& result_;
  double initial_soc_;
  bool open_ = false, link_low_ = false;
  EnergyLedger start_ledger_, lap_ledger_;
  double start_energy_j_ = 0.0, tick_energy_j_ = 0.0, lap_energy_j_ = 0.0, lap_start_s_ = 0.0, lap_start_m_ = 0.0;
  MovingPower moving_power_;
  double power_mean_w_ = 0.0;
  std::array<double, 10> limits_a_{};  ///< what the BMS allowed in the last control periods
  std::size_t next_limit_ = 0;
};

}  // namespace voltlap::plant
