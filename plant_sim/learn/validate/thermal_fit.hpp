// SPDX-License-Identifier: Apache-2.0
// The thermal part of a cell from recorded temperatures, with the heat that the circuit's resistances make
// (reference study, 2016, section 7.5) and the reversible heat (Bernardi et al., J. Electrochem. Soc. 132, 1985):
//
//   C dT/dt = P - e I T - G (T - T_air),   C = m cp [J/K], G = h A [W/K], e = dOCV/dT [V/K]   Eq. 7.7, exact over an
//   L dT_s/dt = T - T_s                    the surface, where a thermistor sits                 interval; T in K
//
// Seen from its surface a cell with a core (Lin et al., J. Power Sources 257, 2014) is the same two poles and no zero.
// Everything is fitted together: 1/C, e/C, starts and airs by linear least squares (thermal_system.hpp), G/C and L by a
// search. A lag that could as well be none is none. Intervals are 95 %, of the covariance of all of them together, with
// what is assumed of e and of the air in it; residuals that stay count once.
//
// A discharge at one current does not tell 1/C from e/C: what such data tell is a line, C as a function of e. The fit
// gives each number with the interval that it has alone, says which are not told, and gives the line.
#pragma once
#include <string>
#include <vector>

#include "learn/validate/thermal_recording.hpp"

namespace voltlap::plant {

/// Two numbers that go together: `value` of the first where the second is `at`, and `slope` more for each unit of the
/// second.
struct ThermalClass {
  std::string number, unit;    ///< of the first
  double value = 0.0, ci95 = 0.0;  ///< half width with the second known
  std::string other, other_unit;
  double at = 0.0, slope = 0.0;
};

struct ThermalModel {
  double capacity_j_per_k = 0.0, conductance_w_per_k = 0.0;
  double capacity_ci95 = 0.0, conductance_ci95 = 0.0;    ///< half widths, relative
  double surface_lag_s = 0.0, surface_lag_ci95_s = 0.0;  ///< L and its half width
  double entropy_v_per_k = 0.0, entropy_ci95_v_per_k = 0.0;
  bool capacity_told = true, conductance_told = true, entropy_told = true;
  std::vector<ThermalClass> classes;
  std::vector<double> air_c, air_ci95_k;  ///< of each recording; of one that recorded it, its first and 0
};

/// Throws InputError when the temperatures do not rise enough above their steps to tell a heat capacity.
[[nodiscard]] ThermalModel fit_thermal(const std::vector<ThermalRecording>& recordings);

}  // namespace voltlap::plant
