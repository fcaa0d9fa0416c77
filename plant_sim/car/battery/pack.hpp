// SPDX-License-Identifier: Apache-2.0
// The battery pack: cells in series, each a circuit of 1 to 4 RC branches with its own SOC and temperature.
//
//   V = OCV(SOC) - sum(v) - R0 I             (discharge current I positive); of a step its mean
//   pack V = sum of V - R_contact I
//   dv/dt = (I - v/R) / C,  tau = R C        exact over a step of constant I (first_order.hpp)
//   dSOC/dt = -I / (3600 Ah)
//   m cp dT/dt = I^2 R0 + sum(v^2/R) - h A (T - T_ambient)
// Source: reference study, 2016, Eq. 4.18-4.24, 7.6, 7.7; signs after Thevenin. Lookup tables and temperatures are
// renewed once per control period (10 ms): SOC moves less than 1e-4 of a breakpoint interval in that time. One cell
// under a current that is known beforehand: cell.hpp.
#pragma once
#include <array>
#include <cstddef>
#include <vector>

#include "car/battery/cell_effects.hpp"
#include "car/battery/cell_tables.hpp"
#include "car/battery/cell_thermal.hpp"
#include "core/parameters.hpp"

namespace voltlap::plant {

/// What one step turned into what, in joules, summed over the pack. chemical = heats + stored + terminal energy.
struct PackEnergy {
  double chemical_j = 0.0;  ///< I OCV dt
  double r0_heat_j = 0.0;   ///< I^2 (R0 + R_contact) dt
  double rc_heat_j = 0.0;   ///< v^2/R dt, of the branches
  double rc_stored_j = 0.0; ///< v C dv, of the branches
};

/// The pack as its load sees it over the coming step: V = voltage_v - resistance_ohm I, V and I means over the step.
struct PackThevenin {
  double voltage_v = 0.0;
  double resistance_ohm = 0.0;
};

class Pack {
 public:
  /// `representative`: one cell is integrated and stands for all of them; cells must then be equal (InputError if not).
  Pack(const VehicleParameters& car, bool representative, double step_s);

  /// Renews tables and temperatures after `elapsed_s`, during which the heat of the steps was collected.
  void renew(double elapsed_s, double ambient_c);
  /// Renews tables alone, for one coming step whose current is known: at that current and in the middle of the charge
  /// it draws. With long steps (1/8 s, 200 A: 1.3e-4 of SOC) the begin of a step is not good enough.
  void renew_for(double pack_current_a);

  [[nodiscard]] PackThevenin thevenin() const { return thevenin_; }
  /// One step at constant pack current.
  PackEnergy advance(double pack_current_a);
  /// A planted fault: resistances of a cell times `factor` from the next renewal on. A representative cell stands for
  /// all.
  void scale_resistance(std::size_t cell, double factor) { resistance_fault_[index(cell)] = factor; }

  /// The shunts of these cells are on from now on, of all others off. Not with a representative cell.
  void set_bleeding(std::vector<std::size_t> cells);
  [[nodiscard]] const std::vector<std::size_t>& bleeding() const { return bleeding_; }
  /// What the shunts took so far, of all cells: energy, turned to heat outside of the cells, and charge.
  [[nodiscard]] double bleed_energy_j() const { return bleed_energy_j_; }
  [[nodiscard]] double bleed_charge_c() const { return bleed_charge_c_; }
  /// At the ends of the wires that a cell is read by: less than the cell's by what a shunt's current takes there.
  [[nodiscard]] double read_voltage(std::size_t cell) const;

  [[nodiscard]] std::size_t cells() const { return series_; }
  /// Mean of the last step.
  [[nodiscard]] double cell_voltage(std::size_t cell) const { return voltage_[index(cell)]; }
  /// At the end of the last step, while its current still flows.
  [[nodiscard]] double cell_voltage_after_step(std::size_t cell) const;
  [[nodiscard]] double cell_soc(std::size_t cell) const { return soc_[index(cell)]; }
  [[nodiscard]] double cell_temperature_c(std::size_t cell) const { return temperature_[index(cell)]; }
  /// Where a thermistor sits: behind the cell by `cell.surface_lag_s`.
  [[nodiscard]] double surface_temperature_c(std::size_t cell) const { return surface_[index(cell)]; }
  [[nodiscard]] double voltage() const { return pack_voltage_; }
  [[nodiscard]] double soc_mean() const;
  [[nodiscard]] double temperature_max_c() const;
  /// Lowest cell voltage of the last step.
  [[nodiscard]] double cell_voltage_min() const { return cell_voltage_min_; }
  /// That with the lowest voltage of the last step; of the lowest, of the highest SOC.
  [[nodiscard]] std::size_t weakest_cell() const;
  [[nodiscard]] std::size_t emptiest_cell() const;
  [[nodiscard]] std::size_t fullest_cell() const;
  /// Charge taken out of one cell-file cell so far [Ah], from the current alone.
  [[nodiscard]] double charge_out_ah() const { return charge_out_as_ / 3600.0; }
  [[nodiscard]] double capacity_ah(std::size_t cell) const;
  [[nodiscard]] const CellTables& tables() const { return tables_; }
  [[nodiscard]] double lookup_current_a() const { return lookup_current_; }

 private:
  [[nodiscard]] std::size_t index(std::size_t cell) const { return representative_ ? 0 : cell; }
  /// Generated for each number of branches.
  template <std::size_t N>
  void renew_of(double elapsed_s, double ambient_c);
  template <std::size_t N>
  void renew_for_of(double current_a);
  template <std::size_t N>
  PackEnergy advance_of(double pack_current_a);
  template <std::size_t N>
  void look_up(std::size_t i, double soc, double current_a);
  template <std::size_t N>
  void sum_thevenin();
  /// Dynamic effects, leaks and the reversible heat of a step; `current_a` of one cell-file cell.
  void advance_effects(double current_a);
  void advance_bleeding();

  CellTables tables_;
  std::size_t series_, count_;
  bool representative_;
  double parallel_, multiplicity_, step_s_;
  CellEffects effects_;
  CellThermal thermal_;
  double lookup_floor_a_, contact_ohm_, shunt_ohm_, sense_ohm_;
  double bleed_energy_j_ = 0.0, bleed_charge_c_ = 0.0;
  double lookup_current_ = 0.0;
  double cell_current_ = 0.0;  // of the last step
  double pack_voltage_ = 0.0, cell_voltage_min_ = 0.0, charge_out_as_ = 0.0;
  PackThevenin thevenin_;
  // One array a quantity, so that the loop over cells runs in vector registers.
  std::vector<double> soc_, ocv_, voltage_, temperature_, surface_, heat_j_;  // state
  std::vector<CellEffectState> effect_;                                                 // state; empty: none is on
  std::vector<double> leak_a_;                                                          // fixed; empty: none
  std::vector<std::size_t> bleeding_;                                                   // state; empty: none
  std::vector<double> soc_per_amp_, resistance_scale_;                                  // fixed
  std::vector<double> resistance_fault_;                                                // planted, 1 none
  std::vector<double> r0_, ocv_per_amp_, r_step_;                                       // per renewal
  struct Branch {
    std::vector<double> v;                                           // state
    std::vector<double> g, c, decay, gain, mean_decay, mean_gain;  // per renewal
  };
  std::array<Branch, kMostCellBranches> branch_;
};

}  // namespace voltlap::plant
