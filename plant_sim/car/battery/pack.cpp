// SPDX-License-Identifier: Apache-2.0
#include "car/battery/pack.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

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
      contact_ohm_(car.battery.contact_resistance_ohm),
      shunt_ohm_(car.battery.balancing_resistance_ohm),
      sense_ohm_(car.battery.sense_resistance_ohm) {
  if (representative && !std::all_of(car.battery.cells.begin(), car.battery.cells.end(), is_nominal)) {
    throw InputError("battery.cells.<n>.*", "cells that differ", "cells that are all equal, which one can represent",
                     "Use --cells all, or leave these settings out");
  }
  if (car.battery.cells.size() > series_) {
    throw InputError(fmt::format("battery.cells.{}", car.battery.cells.size()), "a cell that the pack does not have",
                     fmt::format("a cell from 1 to {}", series_), "Check the number, or battery.cells_in_series");
  }
  for (auto* array : {&soc_, &ocv_, &voltage_, &temperature_, &surface_, &heat_j_, &soc_per_amp_, &resistance_scale_,
                      &r0_, &ocv_per_amp_, &r_step_}) {
    array->assign(count_, 0.0);
  }
  for (std::size_t k = 0; k < tables_.branches(); ++k) {
    Branch& b = branch_[k];
    for (auto* array : {&b.v, &b.g, &b.c, &b.decay, &b.gain, &b.mean_decay, &b.mean_gain}) array->assign(count_, 0.0);
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
  for (std::size_t i = 0; i < effect_.size(); ++i) effect_[i].hysteresis = hysteresis_at_begin(soc_[i]);
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
  with_branches(tables_.branches(), [&](auto n) { renew_of<n>(elapsed_s, ambient_c); });
}

template <std::size_t N>
void Pack::renew_of(double elapsed_s, double ambient_c) {
  const double decay = thermal_.decay(elapsed_s);
  for (std::size_t i = 0; i < count_; ++i) {
    if (elapsed_s > 0.0) {
      const double before = temperature_[i];
      temperature_[i] = temperature_after(thermal_, before, heat_j_[i] / elapsed_s, ambient_c, elapsed_s, decay);
      surface_[i] = surface_after(surface_[i], before, temperature_[i], thermal_.surface_lag_s, elapsed_s);
    }
    heat_j_[i] = 0.0;
    ocv_[i] = tables_.ocv_v(soc_[i], temperature_[i]);
    look_up<N>(i, soc_[i], lookup_current_);
  }
  sum_thevenin<N>();
}

void Pack::renew_for(double pack_current_a) {
  const double current = pack_current_a / parallel_;
  if (std::abs(current) > lookup_floor_a_) lookup_current_ = std::abs(current);
  with_branches(tables_.branches(), [&](auto n) { renew_for_of<n>(current); });
}

template <std::size_t N>
void Pack::renew_for_of(double current_a) {
  for (std::size_t i = 0; i < count_; ++i) {
    look_up<N>(i, soc_[i] - 0.5 * soc_per_amp_[i] * current_a, lookup_current_);
  }
  sum_thevenin<N>();
}

template <std::size_t N>
void Pack::look_up(std::size_t i, double soc, double current_a) {
  const CircuitOf<N> p = tables_.circuit_of<N>(soc, temperature_[i], current_a);
  const double scale = resistance_scale_[i] * resistance_fault_[i];
  r0_[i] = p.r0_ohm * scale;
  double r_step = r0_[i];
  for_each_branch<N>([&](auto k) {
    Branch& b = branch_[k];
    const double r = p.r_ohm[k] * scale;
    const HeldBranch held = held_branch(step_s_, p.tau_s[k], r);
    b.g[i] = 1.0 / r;
    b.c[i] = p.tau_s[k] / r;
    b.decay[i] = held.decay;
    b.gain[i] = held.gain;
    b.mean_decay[i] = held.mean_decay;
    b.mean_gain[i] = held.mean_gain;
    r_step += held.mean_gain;
  });
  ocv_per_amp_[i] = tables_.ocv(soc).slope_v * soc_per_amp_[i];
  // Half of the step's fall of the OCV: the mean over the step.
  r_step_[i] = r_step + 0.5 * ocv_per_amp_[i];
}

template <std::size_t N>
void Pack::sum_thevenin() {
  double voltage = 0.0;
  double resistance = 0.0;
  for (const CellEffectState& state : effect_) voltage -= drop_of(effects_, state);
  for (std::size_t i = 0; i < count_; ++i) {
    double own = ocv_[i];
    for_each_branch<N>([&](auto k) { own -= branch_[k].mean_decay[i] * branch_[k].v[i]; });
    voltage += own;
    resistance += r_step_[i];
  }
  const double in_series = multiplicity_ / parallel_;
  thevenin_ = {voltage * in_series, resistance * in_series / parallel_ + contact_ohm_};
}

PackEnergy Pack::advance(double pack_current_a) {
  return with_branches(tables_.branches(), [&](auto n) { return advance_of<n>(pack_current_a); });
}

template <std::size_t N>
PackEnergy Pack::advance_of(double pack_current_a) {
  const double current = pack_current_a / parallel_;
  const double charge = current * step_s_;
  const bool with_effects = !effect_.empty();
  double chemical = 0.0, r0_heat = 0.0, rc_heat = 0.0, rc_stored = 0.0, next_voltage = 0.0, sum_voltage = 0.0;
  double lowest = 1e9;
  for (std::size_t i = 0; i < count_; ++i) {
    const double ocv = ocv_[i] - 0.5 * ocv_per_amp_[i] * current;
    double voltage = ocv, branch_w = 0.0, stored = 0.0;
    for_each_branch<N>([&](auto k) {
      Branch& b = branch_[k];
      const double from = b.v[i], mean = b.mean_decay[i] * from + b.mean_gain[i] * current,
                   next = b.decay[i] * from + b.gain[i] * current;
      branch_w += b.g[i] * mean * mean;
      stored += b.c[i] * (next - from) * mean;
      voltage -= mean;
      b.v[i] = next;
    });
    voltage -= r0_[i] * current;
    const double r0_j = r0_[i] * current * charge, branch_j = branch_w * step_s_;
    if (with_effects) {
      const double drop = drop_of(effects_, effect_[i]);
      voltage -= drop;
      next_voltage -= drop;
      rc_heat += drop * charge;  // what these branches store is counted as their heat
      heat_j_[i] += drop * charge;
    }
    chemical += ocv * charge;
    r0_heat += r0_j;
    rc_heat += branch_j;
    rc_stored += stored;
    heat_j_[i] += r0_j + branch_j;
    soc_[i] -= soc_per_amp_[i] * current;
    ocv_[i] -= ocv_per_amp_[i] * current;
    voltage_[i] = voltage;
    sum_voltage += voltage;
    lowest = std::min(lowest, voltage);
    double next_own = ocv_[i];
    for_each_branch<N>([&](auto k) { next_own -= branch_[k].mean_decay[i] * branch_[k].v[i]; });
    next_voltage += next_own;
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
  if (!bleeding_.empty()) advance_bleeding();
  if (effects_.entropy_v_per_k == 0.0) return;
  for (std::size_t i = 0; i < count_; ++i) {
    heat_j_[i] += reversible_heat(effects_, current_a, temperature_[i]) * step_s_;
  }
}

void Pack::set_bleeding(std::vector<std::size_t> cells) {
  VOLTLAP_DEMAND(cells.empty() || !representative_);
  VOLTLAP_DEMAND(std::all_of(cells.begin(), cells.end(), [&](std::size_t cell) { return cell < count_; }));
  bleeding_ = std::move(cells);
}

/// A shunt's current is a leak that ends in a resistor; it is far too small to polarize the cell.
void Pack::advance_bleeding() {
  for (const std::size_t i : bleeding_) {
    const double current = voltage_[i] / (shunt_ohm_ + sense_ohm_), own = current / parallel_;
    soc_[i] -= soc_per_amp_[i] * own;
    ocv_[i] -= ocv_per_amp_[i] * own;
    bleed_charge_c_ += current * step_s_;
    bleed_energy_j_ += current * voltage_[i] * step_s_;
  }
}

double Pack::read_voltage(std::size_t cell) const {
  const std::size_t i = index(cell);
  if (bleeding_.empty() || std::find(bleeding_.begin(), bleeding_.end(), i) == bleeding_.end()) return voltage_[i];
  const double current = voltage_[i] / (shunt_ohm_ + sense_ohm_);
  return voltage_[i] - current * (sense_ohm_ + r0_[i] / parallel_);
}

double Pack::cell_voltage_after_step(std::size_t cell) const {
  const std::size_t i = index(cell);
  const double effects_v = effect_.empty() ? 0.0 : drop_of(effects_, effect_[i]);
  double out = ocv_[i];
  for (std::size_t k = 0; k < tables_.branches(); ++k) out -= branch_[k].v[i];
  return out - r0_[i] * cell_current_ - effects_v;
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
