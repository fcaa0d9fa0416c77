// SPDX-License-Identifier: Apache-2.0
#include "car/battery/pack.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

#include "core/demand.hpp"
#include "core/errors.hpp"

namespace voltlap::plant {
namespace {

constexpr double kSecondsPerHour = 3600.0;

CellVariation variation_of(const BatterySection& battery, std::size_t cell) {
  return cell < battery.cells.size() ? battery.cells[cell] : CellVariation{};
}

bool is_nominal(const CellVariation& v) {
  return v.capacity_scale == 1.0 && v.resistance_scale == 1.0 && v.initial_soc_offset == 0.0 && v.leak_a == 0.0;
}

}  // namespace

Pack::Pack(const VehicleParameters& car, bool representative, double step_s)
    : tables_(car.cell),
      series_(static_cast<std::size_t>(car.battery.cells_in_series)),
      count_(representative ? 1 : series_),
      representative_(representative),
      parallel_(car.battery.cells_in_parallel),
      multiplicity_(parallel_ * (representative ? static_cast<double>(series_) : 1.0)),
      step_s_(step_s),
      effects_(car.cell.effects),
      thermal_(thermal_of(car.cell)),
      lookup_floor_a_(car.battery.lookup_current_floor_a),
      contact_ohm_(car.battery.contact_resistance_ohm) {
  if (representative && !std::all_of(car.battery.cells.begin(), car.battery.cells.end(), is_nominal)) {
    throw InputError("battery.cells.<n>.*", "cells that differ", "cells that are all equal, which one can represent",
                     "Use --cells all, or leave these settings out");
  }
  if (car.battery.cells.size() > series_) {
    throw InputError(fmt::format("battery.cells.{}", car.battery.cells.size()), "a cell that the pack does not have",
                     fmt::format("a cell from 1 to {}", series_), "Check the number, or battery.cells_in_series");
  }
  for (auto* array : {&soc_, &v1_, &v2_, &ocv_, &voltage_, &temperature_, &surface_, &heat_j_, &soc_per_amp_,
                      &resistance_scale_, &r0_, &g1_, &g2_, &c1_, &c2_, &ocv_per_amp_, &decay1_, &decay2_, &gain1_,
                      &gain2_, &mean_decay1_, &mean_decay2_, &mean_gain1_, &mean_gain2_, &r_step_}) {
    array->assign(count_, 0.0);
  }
  for (std::size_t i = 0; i < count_; ++i) {
    const CellVariation v = variation_of(car.battery, i);
    soc_[i] = car.battery.initial_soc + v.initial_soc_offset;
    temperature_[i] = surface_[i] = car.battery.initial_temperature_c;
    soc_per_amp_[i] = step_s / (kSecondsPerHour * car.cell.capacity_ah * v.capacity_scale);
    resistance_scale_[i] = v.resistance_scale;
  }
  resistance_fault_.assign(count_, 1.0);
  if (has_dynamics(effects_)) effect_.resize(count_);
  if (std::any_of(car.battery.cells.begin(), car.battery.cells.end(), [](const auto& v) { return v.leak_a != 0.0; })) {
    for (std::size_t i = 0; i < count_; ++i) leak_a_.push_back(variation_of(car.battery, i).leak_a);
  }
  renew(0.0, car.environment.ambient_c);
  for (std::size_t i = 0; i < count_; ++i) voltage_[i] = ocv_[i];
  pack_voltage_ = thevenin_.voltage_v;
  cell_voltage_min_ = *std::min_element(voltage_.begin(), voltage_.end());
}

void Pack::renew(double elapsed_s, double ambient_c) {
  VOLTLAP_DEMAND(elapsed_s >= 0.0);
  const double decay = thermal_.decay(elapsed_s);
  for (std::size_t i = 0; i < count_; ++i) {
    if (elapsed_s > 0.0) {
      const double before = temperature_[i];
      temperature_[i] = temperature_after(thermal_, before, heat_j_[i] / elapsed_s, ambient_c, elapsed_s, decay);
      surface_[i] = surface_after(surface_[i], before, temperature_[i], thermal_.surface_lag_s, elapsed_s);
    }
    heat_j_[i] = 0.0;
    ocv_[i] = tables_.ocv_v(soc_[i], temperature_[i]);
    look_up(i, soc_[i], lookup_current_);
  }
  sum_thevenin();
}

void Pack::renew_for(double pack_current_a) {
  const double current = pack_current_a / parallel_;
  if (std::abs(current) > lookup_floor_a_) lookup_current_ = std::abs(current);
  for (std::size_t i = 0; i < count_; ++i) look_up(i, soc_[i] - 0.5 * soc_per_amp_[i] * current, lookup_current_);
  sum_thevenin();
}

void Pack::look_up(std::size_t i, double soc, double current_a) {
  const CircuitParameters p = tables_.circuit(soc, temperature_[i], current_a);
  const double scale = resistance_scale_[i] * resistance_fault_[i];
  const double r1 = p.r1_ohm * scale;
  const double r2 = p.r2_ohm * scale;
  r0_[i] = p.r0_ohm * scale;
  g1_[i] = 1.0 / r1;
  g2_[i] = 1.0 / r2;
  c1_[i] = p.tau1_s / r1;
  c2_[i] = p.tau2_s / r2;
  const HeldBranch one = held_branch(step_s_, p.tau1_s, r1), two = held_branch(step_s_, p.tau2_s, r2);
  decay1_[i] = one.decay;
  decay2_[i] = two.decay;
  gain1_[i] = one.gain;
  gain2_[i] = two.gain;
  mean_decay1_[i] = one.mean_decay;
  mean_decay2_[i] = two.mean_decay;
  mean_gain1_[i] = one.mean_gain;
  mean_gain2_[i] = two.mean_gain;
  ocv_per_amp_[i] = tables_.ocv(soc).slope_v * soc_per_amp_[i];
  // Half of the step's fall of the OCV: the mean over the step.
  r_step_[i] = r0_[i] + mean_gain1_[i] + mean_gain2_[i] + 0.5 * ocv_per_amp_[i];
}

void Pack::sum_thevenin() {
  double voltage = 0.0;
  double resistance = 0.0;
  for (const CellEffectState& state : effect_) voltage -= drop_of(effects_, state);
  for (std::size_t i = 0; i < count_; ++i) {
    voltage += ocv_[i] - mean_decay1_[i] * v1_[i] - mean_decay2_[i] * v2_[i];
    resistance += r_step_[i];
  }
  const double in_series = multiplicity_ / parallel_;
  thevenin_ = {voltage * in_series, resistance * in_series / parallel_ + contact_ohm_};
}

PackEnergy Pack::advance(double pack_current_a) {
  const double current = pack_current_a / parallel_;
  const double charge = current * step_s_;
  const bool with_effects = !effect_.empty();
  double chemical = 0.0, r0_heat = 0.0, rc_heat = 0.0, rc_stored = 0.0, next_voltage = 0.0, sum_voltage = 0.0;
  double lowest = 1e9;
  for (std::size_t i = 0; i < count_; ++i) {
    const double mean1 = mean_decay1_[i] * v1_[i] + mean_gain1_[i] * current;
    const double mean2 = mean_decay2_[i] * v2_[i] + mean_gain2_[i] * current;
    const double next1 = decay1_[i] * v1_[i] + gain1_[i] * current;
    const double next2 = decay2_[i] * v2_[i] + gain2_[i] * current;
    const double heat0 = r0_[i] * current * charge;
    const double heat12 = (g1_[i] * mean1 * mean1 + g2_[i] * mean2 * mean2) * step_s_;
    const double ocv = ocv_[i] - 0.5 * ocv_per_amp_[i] * current;
    double voltage = ocv - mean1 - mean2 - r0_[i] * current;
    if (with_effects) {
      const double drop = drop_of(effects_, effect_[i]);
      voltage -= drop;
      next_voltage -= drop;
      rc_heat += drop * charge;  // what these branches store is counted as their heat
      heat_j_[i] += drop * charge;
    }
    chemical += ocv * charge;
    r0_heat += heat0;
    rc_heat += heat12;
    rc_stored += c1_[i] * (next1 - v1_[i]) * mean1 + c2_[i] * (next2 - v2_[i]) * mean2;
    heat_j_[i] += heat0 + heat12;
    v1_[i] = next1;
    v2_[i] = next2;
    soc_[i] -= soc_per_amp_[i] * current;
    ocv_[i] -= ocv_per_amp_[i] * current;
    voltage_[i] = voltage;
    sum_voltage += voltage;
    lowest = std::min(lowest, voltage);
    next_voltage += ocv_[i] - mean_decay1_[i] * next1 - mean_decay2_[i] * next2;
  }
  advance_effects(current);
  const double in_series = multiplicity_ / parallel_;
  thevenin_.voltage_v = next_voltage * in_series;
  const double contact_v = contact_ohm_ * pack_current_a;
  pack_voltage_ = sum_voltage * in_series - contact_v;
  cell_voltage_min_ = lowest;
  charge_out_as_ += charge;
  cell_current_ = current;
  if (std::abs(current) > lookup_floor_a_) lookup_current_ = std::abs(current);
  const double contact_heat = contact_v * pack_current_a * step_s_;
  return {chemical * multiplicity_, r0_heat * multiplicity_ + contact_heat, rc_heat * multiplicity_,
          rc_stored * multiplicity_};
}

void Pack::advance_effects(double current_a) {
  for (std::size_t i = 0; i < effect_.size(); ++i) {
    plant::advance(effects_, effect_[i], current_a, current_a, capacity_ah(i), step_s_);
  }
  for (std::size_t i = 0; i < leak_a_.size(); ++i) {
    soc_[i] -= soc_per_amp_[i] * leak_a_[i];
    ocv_[i] -= ocv_per_amp_[i] * leak_a_[i];
  }
  if (effects_.entropy_v_per_k == 0.0) return;
  for (std::size_t i = 0; i < count_; ++i) {
    heat_j_[i] += reversible_heat(effects_, current_a, temperature_[i]) * step_s_;
  }
}

double Pack::cell_voltage_after_step(std::size_t cell) const {
  const std::size_t i = index(cell);
  const double effects_v = effect_.empty() ? 0.0 : drop_of(effects_, effect_[i]);
  return ocv_[i] - v1_[i] - v2_[i] - r0_[i] * cell_current_ - effects_v;
}

double Pack::soc_mean() const {
  return std::accumulate(soc_.begin(), soc_.end(), 0.0) / static_cast<double>(count_);
}

double Pack::temperature_max_c() const { return *std::max_element(temperature_.begin(), temperature_.end()); }

std::size_t Pack::weakest_cell() const {
  return static_cast<std::size_t>(std::min_element(voltage_.begin(), voltage_.end()) - voltage_.begin());
}

std::size_t Pack::emptiest_cell() const {
  return static_cast<std::size_t>(std::min_element(soc_.begin(), soc_.end()) - soc_.begin());
}

std::size_t Pack::fullest_cell() const {
  return static_cast<std::size_t>(std::max_element(soc_.begin(), soc_.end()) - soc_.begin());
}

double Pack::capacity_ah(std::size_t cell) const { return step_s_ / (kSecondsPerHour * soc_per_amp_[index(cell)]); }

}  // namespace voltlap::plant
