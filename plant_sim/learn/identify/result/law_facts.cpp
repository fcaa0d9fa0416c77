// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/result/law_facts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/demand.hpp"
#include "core/number_text.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;

constexpr double kInterval = 1.96;

}  // namespace

std::vector<LawFact> law_facts(const IdentifyResult& result) {
  constexpr double kTold = 2.0 / 3.0;  // of what was believed before
  constexpr double kJoules = 1e3;
  const ResistanceLaws& laws = result.model.laws;
  std::vector<LawFact> out;
  if (!laws.has_temperature() && !laws.has_charge_transfer() && !laws.has_hysteresis()) return out;
  const LawPriors priors;
  const bool has_intervals = result.packed.size() > 0 && result.uncertainty.sigma.size() == result.packed.size();
  const auto sigma_of = [&](Index place) {
    const bool by_temperature = place != ResistanceLaws::kLogExchange && place != ResistanceLaws::kHysteresis;
    return has_intervals && !(by_temperature && result.laws_assumed) ? result.uncertainty.sigma(result.packed.size() - ResistanceLaws::kCount + place)
                         : priors.sigma(place);
  };
  struct Energy {
    std::string_view key, label;
    Index place;
  };
  constexpr std::array<Energy, 3> kEnergies{{
      {"ohmic_activation_energy", "R0 with temperature", ResistanceLaws::kOhmic},
      {"polarization_activation_energy", "R1.. with temperature", ResistanceLaws::kPolarization},
      {"time_constant_activation_energy", "tau with temperature", ResistanceLaws::kTimeConstant}}};
  for (const Energy& energy : kEnergies) {
    const double value = laws.packed()(energy.place), sigma = sigma_of(energy.place);
    const bool bounded = energy.place != ResistanceLaws::kTimeConstant;
    const double low = value - kInterval * sigma;
    out.push_back({energy.key, energy.label, "J/mol", kJoules * value, kJoules * (bounded ? std::max(0.0, low) : low),
                   kJoules * (value + kInterval * sigma),
                   sigma < kTold * priors.sigma(energy.place) ? FactOrigin::kMeasured : FactOrigin::kAssumed,
                   bounded && value <= 0.0});
  }
  if (laws.has_hysteresis()) {
    constexpr double kMillivolt = 1e-3;
    const double half = kInterval * sigma_of(ResistanceLaws::kHysteresis);
    out.push_back({"hysteresis", "hysteresis", "V", kMillivolt * laws.hysteresis_mv,
                   kMillivolt * (laws.hysteresis_mv - half), kMillivolt * (laws.hysteresis_mv + half),
                   FactOrigin::kMeasured});
  }
  const double entropy_sigma = sigma_of(ResistanceLaws::kEntropy);
  if (entropy_sigma < kTold * priors.sigma(ResistanceLaws::kEntropy)) {
    constexpr double kMillivolt = 1e-3;
    const double half = kInterval * entropy_sigma;
    out.push_back({"entropy", "OCV with temperature", "V/K", kMillivolt * laws.entropy_mv_per_k,
                   kMillivolt * (laws.entropy_mv_per_k - half), kMillivolt * (laws.entropy_mv_per_k + half),
                   FactOrigin::kMeasured});
  }
  if (laws.has_charge_transfer()) {
    const double sigma = sigma_of(ResistanceLaws::kLogExchange), factor = std::exp(kInterval * std::min(sigma, 10.0));
    out.push_back({"exchange_current", "R0 with current", "A", laws.exchange_a, laws.exchange_a / factor,
                   laws.exchange_a * factor,
                   sigma < kTold * priors.sigma(ResistanceLaws::kLogExchange) ? FactOrigin::kMeasured
                                                                             : FactOrigin::kAssumed});
  }
  VOLTLAP_DEMAND(out.size() >= kEnergies.size());
  return out;
}

std::string law_origin(const std::vector<LawFact>& facts, std::string_view key) {
  for (const LawFact& fact : facts) {
    if (fact.key != key) continue;
    return fmt::format("{}, {:.4g} to {:.4g} {}", fact.origin == FactOrigin::kMeasured ? "identified" : "assumed",
                       fact.ci95_low, fact.ci95_high, fact.unit);
  }
  return "assumed";
}

std::string laws_text(const IdentifyResult& result) {
  std::string out;
  for (const LawFact& fact : law_facts(result)) {
    const bool volts = fact.unit == "V/K";  // a few tenths of a millivolt
    const double scale = volts ? 1e3 : 1.0;
    out += fmt::format("  {:<21} {:>9} {:<5} {:<9} {} to {}{}\n", fact.label, short_number(scale * fact.value),
                       volts ? "mV/K" : fact.unit, name_of(fact.origin), short_number(scale * fact.ci95_low),
                       short_number(scale * fact.ci95_high), fact.at_bound ? ", at its bound" : "");
  }
  return out;
}

}  // namespace voltlap::plant
