// SPDX-License-Identifier: Apache-2.0
// A cell's parameters as lookup tables: R0, R and tau of each branch over (SOC, temperature, current), OCV over SOC.
// Trilinear between breakpoints, held at the ends (reference study, 2016, sections 4.8.2 and 6.7, Table 6.9).
//
// A curve over SOC, `value`, is that at the reference point (T_ref, I_ref):
//   p(s, T, I) = value(s) (1 + per_kelvin (T - T_ref)) (1 + per_ampere (I - I_ref)) exp(Ea/Rg (1/T - 1/T_ref))
//   R0         = that + v_ct(I, T) / I with the exchange current i0 exp(-Ei/Rg (1/T - 1/T_ref))
//
// With `breakpoints.kinetic_law`, which identified cells have, kinetics say what is between the points:
//   ln p    straight over 1/T, also 10 K beyond the ends     Arrhenius; p: R0, sum of the branches' R, each tau
//   R0(I)   r(I) + v_ct(I)/I, r straight over I, v_ct as in car/battery/cell_effects.hpp with the exchange current that
//           fits the table best; from no current to 1.5 times the largest     Butler-Volmer
// The tables are laid out more finely once; a lookup stays trilinear.
#pragma once
#include <vector>

#include "car/battery/branches.hpp"
#include "core/parameters.hpp"

namespace voltlap::plant {

struct OcvPoint {
  double voltage_v;
  double slope_v;  ///< dOCV/dSOC [V]
};

class CellTables {
 public:
  /// Expands the maps of a cell file. Throws InputError that names the cell's field when a breakpoint list is not
  /// increasing, a size does not fit, a resistance or time constant is not positive, or the OCV falls with SOC.
  explicit CellTables(const CellParameters& cell);

  /// `current_a` is the magnitude of the (last non-zero) current of one cell. With the cell's effects that act at once
  /// (car/battery/cell_effects.hpp).
  [[nodiscard]] CircuitParameters circuit(double soc, double temperature_c, double current_a) const;
  /// The same where the number of branches is known.
  template <std::size_t N>
  [[nodiscard]] CircuitOf<N> circuit_of(double soc, double temperature_c, double current_a) const;

  [[nodiscard]] std::size_t branches() const { return branches_; }

  /// OCV by linear interpolation in a dense uniform grid; extrapolated with the end slope outside 0..1.
  [[nodiscard]] OcvPoint ocv(double soc) const;

  /// OCV at a temperature: that of the curve and, with the entropy, what the temperature adds.
  [[nodiscard]] double ocv_v(double soc, double temperature_c) const;

  /// SOC at which the OCV is `voltage_v` at a temperature, 0..1.
  [[nodiscard]] double soc_of_ocv(double voltage_v, double temperature_c) const;

 private:
  static constexpr std::size_t kOcvIntervals = 1000;

  struct Axis {
    std::vector<double> at;
    struct Place {
      std::size_t index;
      double fraction;
    };
    [[nodiscard]] Place find(double x) const;
  };

  /// Exchange current [A] with which the charge transfer bends R0 over the currents at one temperature.
  [[nodiscard]] double exchange_current(std::size_t temperature) const;

  /// A node's parameters: R0, R1 .. RN, tau1 .. tauN.
  [[nodiscard]] std::size_t width() const { return 2 * branches_ + 1; }
  [[nodiscard]] const double* node(std::size_t index) const { return &nodes_[index * width()]; }

  /// Lay the tables out more finely, by kinetics between the breakpoints.
  void refine_over_temperature();
  void refine_over_current();

  std::size_t branches_;
  Axis soc_, temperature_, current_;
  CellEffects effects_;
  double reference_temperature_c_ = 25.0;
  std::vector<double> log_exchange_;  // ln of the exchange current [A] by temperature; empty: not asked for
  std::vector<double> nodes_;  // [soc][temperature][current], a node's parameters together
  std::vector<double> ocv_;
};

}  // namespace voltlap::plant
