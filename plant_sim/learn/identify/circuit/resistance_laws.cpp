// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/circuit/resistance_laws.hpp"

#include <cmath>

#include "core/demand.hpp"

namespace voltlap::plant {

ResistanceLaws::Packed ResistanceLaws::packed() const {
  Packed out;
  out(kOhmic) = ohmic_kj_per_mol;
  for (std::size_t k = 0; k < branch_kj_per_mol.size(); ++k) {
    out(resistance(static_cast<Eigen::Index>(k))) = branch_kj_per_mol[k].resistance;
    out(time_constant(static_cast<Eigen::Index>(k))) = branch_kj_per_mol[k].time_constant;
  }
  out(kLogExchange) = has_charge_transfer() ? std::log(exchange_a) : 0.0;
  out(kEntropy) = entropy_mv_per_k;
  out(kHysteresis) = hysteresis_mv;
  return out;
}

void ResistanceLaws::take(const Packed& packed) {
  VOLTLAP_DEMAND(packed.allFinite());
  ohmic_kj_per_mol = packed(kOhmic);
  for (std::size_t k = 0; k < branch_kj_per_mol.size(); ++k)
    branch_kj_per_mol[k] = {packed(resistance(static_cast<Eigen::Index>(k))),
                            packed(time_constant(static_cast<Eigen::Index>(k)))};
  entropy_mv_per_k = packed(kEntropy);
  if (has_hysteresis()) hysteresis_mv = packed(kHysteresis);
  if (has_charge_transfer()) exchange_a = std::exp(packed(kLogExchange));
}

ResistanceLaws::Packed LawPriors::marginal_sigma() const {
  ResistanceLaws::Packed out = sigma;
  for (Eigen::Index place = 0; place < ResistanceLaws::kCount; ++place) {
    if (ResistanceLaws::is_time_constant(place)) out(place) = std::hypot(sigma(place - 1), sigma(place));
  }
  return out;
}

void LawPriors::hold_temperature() {
  constexpr double kHeld = 1e-3;  // of what is believed
  sigma.head(ResistanceLaws::kLogExchange) *= kHeld;
  sigma(ResistanceLaws::kEntropy) *= kHeld;
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
  LawFactors out{std::exp(laws.ohmic_kj_per_mol * x), {}, {}};
  for (std::size_t k = 0; k < out.resistance.size(); ++k) {
    out.resistance[k] = std::exp(laws.branch_kj_per_mol[k].resistance * x);
    out.time_constant[k] = std::exp(laws.branch_kj_per_mol[k].time_constant * x);
  }
  return out;
}

double charge_transfer_drop_v(const ResistanceLaws& laws, double current_a, double temperature_c) {
  if (!laws.has_charge_transfer()) return 0.0;
  const double energy = laws.branch_kj_per_mol[0].resistance;
  const double exchange = laws.exchange_a * std::exp(-energy * laws.inverse(temperature_c));
  return charge_transfer_v(exchange, current_a, temperature_c);
}

}  // namespace voltlap::plant
