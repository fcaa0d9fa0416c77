// SPDX-License-Identifier: Apache-2.0
// The two resistor banks of the bench (reference study, 2016, sections 5.3 and 5.4).
//
//   I = N V / R            R: the low bank as measured, or R_high / n with n resistors in parallel (Eq. 5.2, 5.3)
//   I = V_th / (R_th + R)  the current that a pack with V = V_th - R_th I drives through R: exact, no iteration
#pragma once
#include <string>

#include "car/battery/pack.hpp"
#include "learn/bench/plan.hpp"

namespace voltlap::plant {

struct BankChoice {
  int resistors = 0;  ///< of the high bank; 0: the low bank
  double resistance_ohm = 0.0;
  double nominal_a = 0.0;
  [[nodiscard]] std::string name() const;
};

/// n resistors of the high bank.
[[nodiscard]] BankChoice high_bank(const LoadSection& load, int cells, int resistors);

/// The bank and number of resistors whose nominal current is nearest to `current_a`.
[[nodiscard]] BankChoice choose_bank(const LoadSection& load, int cells, double current_a);

/// Current of the coming step, its mean, through a resistance.
[[nodiscard]] inline double resistor_current(const PackThevenin& source, double resistance_ohm) {
  return source.voltage_v / (source.resistance_ohm + resistance_ohm);
}

}  // namespace voltlap::plant
