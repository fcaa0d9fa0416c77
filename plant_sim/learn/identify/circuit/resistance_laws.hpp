// SPDX-License-Identifier: Apache-2.0
// How a cell's resistances and time constants move with temperature, and its R0 with the current: few numbers that all
// recordings of the cell have together, and that reach beyond the temperatures and currents that were tested.
//
//   R0(T, I) = R0 exp(E_0 x) + v_ct(|I|, T) / |I|     x = (1/T - 1/T_ref) / R_g [mol/kJ], T in K        Arrhenius
//   R_k(T)   = R_k exp(E_k x)                         k = 1 .. K; a slow branch is diffusion, a fast one the surface
//   tau_k(T) = tau_k exp(E_tau,k x)                   of a capacitance that stays E_tau,k is E_k
//   Em(T)    = Em + e (T - T_ref)                     e: entropy over the Faraday constant, one for all SOC
//   V       -= M h,  dh/dSOC_drawn = g (1 - h sign(I)) sign(I)      hysteresis, h from -1 after a charge to 1 (G. L.
//                                                     Plett, J. Power Sources 134, 2004); g is chosen, not fitted
//   v_ct(I)  = 4 R_g T / F asinh(I / 2 i_0(T)),  i_0(T) = i_0 exp(-E_1 x)   Butler-Volmer, two electrodes alike
//
// The charge transfer is on or off as a whole: recordings at one rate cannot tell it from R0. What they do not tell is
// held by what is known of lithium-ion cells: conduction in the electrolyte 10 to 20 kJ/mol (J. Landesfeind and
// H. A. Gasteiger, J. Electrochem. Soc. 166, 2019, A3079), charge transfer 50 to 70 (T. R. Jow et al., J. Electrochem.
// Soc. 159, 2012, A604); the sum that 0.1 to 100 s show lies between them. A branch's 20 is calibrated within that: of
// 15, 20 and 30 kJ/mol from pulses at 25 degC alone, 15 misses a Panasonic 18650PF's US06 at 0 degC most (114 mV; 104;
// 100) and 30 a Leaf cell's 2C, which warms (16 mV; 18; 32). Entropy: within 0.4 mV/K either way over
// SOC, less in its mean (V. Viswanathan et al., J. Power Sources 195, 2010, 3720).
#pragma once
#include <Eigen/Dense>
#include <algorithm>
#include <array>

#include "car/battery/cell_effects.hpp"
#include "core/parameters.hpp"

namespace voltlap::plant {

struct ResistanceLaws {
  /// Places in `packed()`; of each branch the energy of its resistance and that of its time constant.
  enum Place : Eigen::Index {
    kOhmic, kBranches, kLogExchange = kBranches + 2 * kMostCellBranches, kEntropy, kHysteresis, kCount
  };
  [[nodiscard]] static constexpr Eigen::Index resistance(Eigen::Index branch) { return kBranches + 2 * branch; }
  [[nodiscard]] static constexpr Eigen::Index time_constant(Eigen::Index branch) { return kBranches + 2 * branch + 1; }
  [[nodiscard]] static constexpr bool is_time_constant(Eigen::Index place) {
    return place > kBranches && place < kLogExchange && (place - kBranches) % 2 == 1;
  }

  double reference_temperature_c = 25.0;
  struct BranchEnergies {
    double resistance = 0.0, time_constant = 0.0;  ///< [kJ/mol]
  };
  double ohmic_kj_per_mol = 0.0;
  std::array<BranchEnergies, kMostCellBranches> branch_kj_per_mol{};
  double entropy_mv_per_k = 0.0;
  double hysteresis_mv = 0.0, hysteresis_per_soc = 0.0;  ///< M and g; g is 0 without hysteresis
  double exchange_a = 0.0;  ///< i_0 at the reference temperature; 0: R0 does not change with the current

  [[nodiscard]] bool has_charge_transfer() const { return exchange_a > 0.0; }
  [[nodiscard]] bool has_hysteresis() const { return hysteresis_per_soc > 0.0; }
  /// x [mol/kJ] of a temperature.
  [[nodiscard]] double inverse(double temperature_c) const {
    constexpr double kJoules = 1e3;
    return kJoules / kGasConstant *
           (1.0 / (temperature_c + kZeroCelsius) - 1.0 / (reference_temperature_c + kZeroCelsius));
  }
  /// What the entropy adds to the OCV [V].
  [[nodiscard]] double reversible_v(double warmer_k) const {
    constexpr double kMillivolt = 1e-3;
    return kMillivolt * entropy_mv_per_k * warmer_k;
  }
  using Packed = Eigen::Vector<double, kCount>;
  /// The numbers as a fit has them: the energies [kJ/mol], ln i_0 (any value without charge transfer), e [mV/K],
  /// M [mV].
  [[nodiscard]] Packed packed() const;
  /// Takes them back; a law without charge transfer stays without.
  void take(const Packed& packed);
  /// Whether anything moves with the temperature.
  [[nodiscard]] bool has_temperature() const {
    return ohmic_kj_per_mol != 0.0 || entropy_mv_per_k != 0.0 ||
           std::any_of(branch_kj_per_mol.begin(), branch_kj_per_mol.end(),
                       [](const BranchEnergies& e) { return e.resistance != 0.0 || e.time_constant != 0.0; });
  }
};

/// What is believed of the numbers before any recording, normal, in the units of packed().
struct LawPriors {
  /// Of a time constant's energy `sigma` is of its difference to that of the resistance.
  ResistanceLaws::Packed mean{15.0, 20.0, 20.0, 20.0, 20.0, 20.0, 20.0, 20.0, 20.0, 0.0, 0.0, 0.0};
  ResistanceLaws::Packed sigma{10.0, 15.0, 10.0, 15.0, 10.0, 15.0, 10.0, 15.0, 10.0, 1.0, 0.15, 1.0};
  bool fixed = false;  ///< the laws stay as they are given
  /// Of each number by itself.
  [[nodiscard]] ResistanceLaws::Packed marginal_sigma() const;
  /// What changes with the temperature stays what is believed, whatever a fit would make of it.
  void hold_temperature();
};
/// The usual ones: R0 15 +- 10 kJ/mol (2 %/K at 25 degC), a branch 20 +- 15, its time constant that of its resistance
/// +- 10; a charge transfer of a third of R0; entropy 0 +- 0.15 mV/K.
[[nodiscard]] LawPriors usual_law_priors(double resistance_ohm, double reference_temperature_c);
/// The laws at the middle of what is believed, without charge transfer.
[[nodiscard]] ResistanceLaws assumed_laws(double reference_temperature_c);

/// What the laws make of one temperature.
struct LawFactors {
  double ohmic = 1.0;
  std::array<double, kMostCellBranches> resistance{1.0, 1.0, 1.0, 1.0}, time_constant{1.0, 1.0, 1.0, 1.0};
};
[[nodiscard]] LawFactors law_factors(const ResistanceLaws& laws, double temperature_c);

/// Volts of the charge transfer at a current of either sign; 0 without.
[[nodiscard]] double charge_transfer_drop_v(const ResistanceLaws& laws, double current_a, double temperature_c);

}  // namespace voltlap::plant
