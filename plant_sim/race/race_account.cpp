// SPDX-License-Identifier: Apache-2.0
#include "race/race_account.hpp"

#include <algorithm>
#include <cmath>

#include "core/demand.hpp"

namespace voltlap::plant {
namespace {

/// Keeps the largest value and when it first came.
void keep_largest(double& largest, double value, double& at_s, double time_s) {
  if (value <= largest) return;
  largest = value;
  at_s = time_s;
}

}  // namespace

RaceAccount::RaceAccount(EnduranceResult& result, const Car& car)
    : result_(result), initial_soc_(car.pack().cell_soc(0)) {
  VOLTLAP_DEMAND(within(initial_soc_, 0.0, 1.0));
  result_.min_pack_voltage_v = result_.min_cell_voltage_v = 1e9;
  result_.max_battery_temp_c = result_.max_motor_temp_c = -1e9;
}

void RaceAccount::open(const Car& car) {
  VOLTLAP_DEMAND(!open_);
  open_ = true;
  lap_ledger_ = start_ledger_ = car.ledger();
  lap_energy_j_ = start_energy_j_ = tick_energy_j_ = car.energy_out_j();
  lap_start_m_ = car.vehicle().distance_m();
  moving_power_.open(start_energy_j_);
}

void RaceAccount::note_step(const Car& car, double time_s) {
  const Pack& pack = car.pack();
  ExtremeTimes& at = result_.extreme_times;
  keep_largest(result_.max_battery_current_a, car.pack_current_a(), at.battery_current_s, time_s);
  keep_largest(result_.max_speed_mps, car.vehicle().speed_mps(), at.speed_s, time_s);
  keep_largest(result_.max_power_w, car.pack_current_a() * pack.voltage(), at.power_s, time_s);
  if (pack.voltage() < result_.min_pack_voltage_v) {
    result_.min_pack_voltage_v = pack.voltage();
    at.pack_voltage_s = time_s;
  }
  if (pack.cell_voltage_min() < result_.min_cell_voltage_v) {
    result_.min_cell_voltage_v = pack.cell_voltage_min();
    result_.min_cell = static_cast<int>(pack.weakest_cell()) + 1;
    at.cell_voltage_s = time_s;
  }
  const bool low = car.contactors.main_closed() && car.dc_link_voltage() < car.parameters().inverter.dc_voltage_min_v;
  if (open_ && low && !link_low_) ++result_.beyond.link_falls;
  link_low_ = low;
}

void RaceAccount::note_tick(const Car& car, const CommandReceiver& ecus, std::size_t limit_reason, double time_s,
                            double tick_s) {
  VOLTLAP_DEMAND(open_ && limit_reason < kLimitReasons);
  VOLTLAP_DEMAND(std::isfinite(car.pack().voltage()) && std::isfinite(car.vehicle().speed_mps()));
  VOLTLAP_DEMAND(std::abs(tick_s * MovingPower::kTicks - MovingPower::kWindow_s) < 1e-9);
  ExtremeTimes& at = result_.extreme_times;
  power_mean_w_ = moving_power_.advance(car.energy_out_j());
  result_.energy_back_kwh += std::max(0.0, tick_energy_j_ - car.energy_out_j()) / kJoulesPerKwh;
  tick_energy_j_ = car.energy_out_j();
  keep_largest(result_.max_power_mean_w, power_mean_w_, at.power_mean_s, time_s);
  keep_largest(result_.max_battery_temp_c, car.pack().temperature_max_c(), at.battery_temp_s, time_s);
  keep_largest(result_.max_motor_temp_c, car.motor_thermal().copper_c(), at.motor_temp_s, time_s);
  if (limit_reason != 0) result_.limit_active_s[limit_reason] += tick_s;
  note_beyond(car, ecus, tick_s);
  if (ecus.bms().soc_ok) {
    result_.bms_counts = true;
    const double soc_error = ecus.bms().soc_ppm * 1e-6 - car.pack().soc_mean();
    result_.bms_soc_error_pct = std::max(result_.bms_soc_error_pct, 100.0 * std::abs(soc_error));
  }
}

void RaceAccount::note_beyond(const Car& car, const CommandReceiver& ecus, double tick_s) {
  BeyondLimits& beyond = result_.beyond;
  const VehicleParameters& p = car.parameters();
  const double least_v = p.bms.cell_voltage_min_v.value_or(p.cell.voltage_min_v);
  if (car.pack().cell_voltage_min() < least_v) beyond.cell_low_s += tick_s;
  // What falls has its way through two nodes and an inverter.
  limits_a_[next_limit_] = ecus.limits().discharge_limit_ok ? 1e-3 * ecus.limits().discharge_limit_ma : 0.0;
  next_limit_ = (next_limit_ + 1) % limits_a_.size();
  const double most_a = *std::max_element(limits_a_.begin(), limits_a_.end());
  constexpr double kShare = 0.02, kFloor_a = 1.0;  // what the commands are rounded to, and the auxiliaries' part
  if (most_a <= 0.0 || car.pack_current_a() <= most_a * (1.0 + kShare) + kFloor_a) return;
  beyond.over_discharge_s += tick_s;
  beyond.over_discharge_share = std::max(beyond.over_discharge_share, car.pack_current_a() / most_a - 1.0);
  beyond.over_discharge_a = std::max(beyond.over_discharge_a, car.pack_current_a() - most_a);
}

void RaceAccount::close_laps(const Car& car, int laps_done, double time_s) {
  if (laps_done <= result_.laps) return;
  VOLTLAP_DEMAND(open_ && time_s > lap_start_s_);
  const EnergyLedger lap = car.ledger().since(lap_ledger_);
  result_.lap_rows.push_back({laps_done, time_s - lap_start_s_, (car.energy_out_j() - lap_energy_j_) / kJoulesPerKwh,
                              100.0 * car.pack().soc_mean(), lap.error_pct(),
                              car.vehicle().distance_m() - lap_start_m_});
  result_.energy_ledger_error_pct = std::max(result_.energy_ledger_error_pct, lap.error_pct());
  result_.laps = laps_done;
  lap_ledger_ = car.ledger();
  lap_energy_j_ = car.energy_out_j();
  lap_start_s_ = time_s;
  lap_start_m_ = car.vehicle().distance_m();
}

void RaceAccount::close(const Car& car) {
  const Pack& pack = car.pack();
  result_.end_soc_pct = 100.0 * pack.soc_mean();
  result_.distance_m = car.vehicle().distance_m();
  result_.energy_out_kwh = (car.energy_out_j() - start_energy_j_) / kJoulesPerKwh;
  result_.ledger = car.ledger().since(start_ledger_);
  const double counted = (initial_soc_ - pack.cell_soc(0)) * pack.capacity_ah(0);
  if (pack.charge_out_ah() != 0.0) {
    result_.charge_balance_error_pct = 100.0 * std::abs(counted / pack.charge_out_ah() - 1.0);
  }
  if (open_) return;
  result_.min_pack_voltage_v = pack.voltage();
  result_.min_cell_voltage_v = pack.cell_voltage_min();
  result_.min_cell = static_cast<int>(pack.weakest_cell()) + 1;
  result_.max_battery_temp_c = pack.temperature_max_c();
  result_.max_motor_temp_c = car.motor_thermal().copper_c();
}

}  // namespace voltlap::plant
