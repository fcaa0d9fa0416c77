// SPDX-License-Identifier: Apache-2.0
// How warm a cell got in a recording without a thermometer: its own heat, and what its body keeps and lets out.
//
//   P = I (OCV - V) - I T dOCV/dT                 Bernardi et al., J. Electrochem. Soc. 132, 1985; T in K
//   P = R(T) I^2 - I T dOCV/dT                    where no open-circuit voltage is known
//   R(T) = R exp(Ea/Rg (1/T - 1/T_ref))           Arrhenius
//   C dT/dt = P - G (T - T_air)                   reference study, 2016, Eq. 7.7, exact over an interval of constant P
//
// A heat that resistance makes is not negative: where noise or a coarse OCV says so it is none.
#pragma once
#include <vector>

#include "car/battery/cell_thermal.hpp"
#include "io/logs/cell_log.hpp"

namespace voltlap::plant {

/// What is known beforehand of the heat that a cell makes.
struct HeatEstimate {
  double resistance_ohm = 0.0;               ///< of the whole drop under a load of minutes, at `reference_c`
  double reference_c = 25.0;                 ///< degC
  double activation_energy_j_per_mol = 0.0;  ///< of the resistance
  std::vector<double> ocv_v;                 ///< [V] by row, NaN where unknown; empty: the resistance alone
  double entropy_v_per_k = 0.0;              ///< dOCV/dT
};

/// Where a cell began.
struct ThermalStart {
  double cell_c = 25.0;
  double air_c = 25.0;  ///< where the log has no ambient
};

/// Temperature within the cell [degC] at every row. Over a gap, whose current is unknown, it cools.
[[nodiscard]] std::vector<double> estimated_temperature(const CellLog& log, CurrentHold hold,
                                                        const CellThermal& thermal, const HeatEstimate& heat,
                                                        const ThermalStart& start);

}  // namespace voltlap::plant
