// SPDX-License-Identifier: Apache-2.0
// One cell under a current that is known: what it makes of it in voltage, charge and heat, interval by interval. The
// recorded currents of validation and explanation go through here; a pack whose load is still to be solved does the
// same with constant currents (pack.hpp), and a test holds the two together.
//
//   V = OCV(s, T) - R0 I - sum(v) - v_e          discharge current I positive; v_e: cell_effects.hpp
//   dv/dt = (R I - v) / tau                      exact for R I / tau straight over the interval, 1/tau the mean of
//                                                its ends: a current that is switched in between charges as much
//   ds = -mean(I) dt / (3600 Ah)
//   P = R0 mean(I^2) + sum(mean(v)^2 / R) + v_e mean(I) - I T dOCV/dT
// Sources: reference study, 2016, Eq. 4.18-4.24, 7.6; signs after Thevenin.
#pragma once
#include <array>

#include "car/battery/cell_effects.hpp"
#include "car/battery/cell_tables.hpp"
#include "car/battery/cell_thermal.hpp"
#include "core/parameters.hpp"

namespace voltlap::plant {

/// An interval of a cell's current, straight from one end to the other.
struct CellInterval {
  double dt_s, begin_a, end_a;

  [[nodiscard]] double mean_a() const { return 0.5 * (begin_a + end_a); }
  [[nodiscard]] double mean_square_a2() const {
    return (begin_a * begin_a + begin_a * end_a + end_a * end_a) / 3.0;
  }
};

/// Share of the charge that an interval draws.
[[nodiscard]] inline double soc_drawn(const CellInterval& interval, double capacity_ah) {
  return interval.mean_a() * interval.dt_s / (3600.0 * capacity_ah);
}

/// What goes on from one interval to the next.
struct CellState {
  double soc = 1.0;
  std::array<double, kMostCellBranches> v{};  ///< of the branches [V]; 0 of those that the cell does not have
  CellEffectState effects;
  double temperature_c = 25.0;     ///< by the cell's own heat
  double surface_c = 25.0;         ///< where a thermistor sits
  double lookup_a = 0.0;           ///< last current above the floor
  double lookup_floor_a = 0.0;     ///< currents up to it, next to none, keep the last lookup current
  CircuitParameters circuit{};     ///< at the end of the last interval

  /// At rest for long: no branch is charged.
  void relax() {
    v = {};
    effects = {};
  }
};

/// What is known at the end of an interval: the current there, and where the tables are read.
struct CellPoint {
  double current_a, soc, at_c;
};

class Cell {
 public:
  /// Throws InputError for tables that do not fit.
  explicit Cell(const CellParameters& cell) : cell_(cell), tables_(cell), thermal_(thermal_of(cell)) {}

  [[nodiscard]] const CellParameters& parameters() const { return cell_; }
  [[nodiscard]] const CellTables& tables() const { return tables_; }
  [[nodiscard]] const CellThermal& thermal() const { return thermal_; }

  /// Reads the tables at a point: all there is to do where nothing is known of what came before.
  void look_up(CellState& state, const CellPoint& at) const;
  /// The interval that ends at a point. Returns its mean heat [W] without the reversible part.
  double advance(CellState& state, const CellInterval& interval, const CellPoint& end) const;
  /// Reversible heat [W].
  [[nodiscard]] double reversible_w(double current_a, double temperature_c) const {
    return reversible_heat(cell_.effects, current_a, temperature_c);
  }
  /// OCV less voltage [V] at a current.
  [[nodiscard]] double drop_v(const CellState& state, double current_a) const {
    double drop = state.circuit.r0_ohm * current_a;
    for (const double v : state.v) drop += v;
    return drop + drop_of(cell_.effects, state.effects);
  }

 private:
  template <std::size_t N>
  double advance_of(CellState& state, const CellInterval& interval, const CellPoint& end) const;

  CellParameters cell_;
  CellTables tables_;
  CellThermal thermal_;
};

/// Cell and surface after `dt_s` of constant heat.
void warm(CellState& state, const CellThermal& thermal, double heat_w, double air_c, double dt_s);

}  // namespace voltlap::plant
