// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/circuit/resistance_laws.hpp"

#include <cmath>

#include "core/demand.hpp"

namespace voltlap::plant {

ResistanceLaws::Packed ResistanceLaws::packed() const {
  const auto& e = branch_kj_per_mol;
  return {ohmic_kj_per_mol, e[0], e[1], e[2], e[3], time_constant_kj_per_mol,
          has_charge_transfer() ? std::log(exchange_a) : 0.0, entropy_mv_per_k, hysteresis_mv};
}

void ResistanceLaws::take(const Packed& packed) {
  VOLTLAP_DEMAND(packed.allFinite());
  ohmic_kj_per_mol = packed(kOhmic);
  for (std::size_t k = 0; k < branch_kj_per_mol.size(); ++k)
    branch_kj_per_mol[k] = packed(kBranch + static_cast<Eigen::Index>(k));
  time_constant_kj_per_mol = packed(kTimeConstant);
  entropy_mv_per_k = packed(kEntropy);
  if (has_hysteresis()) hysteresis_mv = packed(kHysteresis);
  if (has_charge_transfer()) exchange_a = std::exp(packed(kLogExchange));
}

LawPriors usual_law_priors(double resistance_ohm, double reference_temperature_c) {
  constexpr double kShare = 1.0 / 3.0;  // of R0
  VOLTLAP_DEMAND(resistance_ohm > 0.0);
  LawPriors out;
  const double thermal_v = kGasConstant * (reference_temperature_c + kZeroCelsius) / kFaraday;
  // Of small currents v_ct / I = 2 R_g T / (F i_0).
  out.mean(ResistanceLaws::kLogExchange) = std::log(2.0 * thermal_v / (kShare * resistance_ohm));
  return out;
}

ResistanceLaws assumed_laws(double reference_temperature_c) {
  ResistanceLaws out;
  out.reference_temperature_c = reference_temperature_c;
  out.take(LawPriors{}.mean);
  return out;
}

LawFactors law_factors(const ResistanceLaws& laws, double temperature_c) {
  const double x = laws.inverse(temperature_c);
  if (x == 0.0) return {};
  LawFactors out{std::exp(laws.ohmic_kj_per_mol * x), std::exp(laws.time_constant_kj_per_mol * x)};
  for (std::size_t k = 0; k < out.branch.size(); ++k) out.branch[k] = std::exp(laws.branch_kj_per_mol[k] * x);
  return out;
}

double charge_transfer_drop_v(const ResistanceLaws& laws, double current_a, double temperature_c) {
  if (!laws.has_charge_transfer()) return 0.0;
  const double exchange = laws.exchange_a * std::exp(-laws.branch_kj_per_mol[0] * laws.inverse(temperature_c));
  return charge_transfer_v(exchange, current_a, temperature_c);
}

}  // namespace voltlap::plant
