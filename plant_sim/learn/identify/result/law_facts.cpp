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

struct Energy {
  std::string_view key, label;
  bool of_tau = false;
};
/// In the order of ResistanceLaws::packed().
constexpr std::array<Energy, ResistanceLaws::kLogExchange> kEnergies{{
    {"r0_activation_energy", "R0 with temperature"},
    {"r1_activation_energy", "R1 with temperature"},
    {"tau1_activation_energy", "tau1 with temperature", true},
    {"r2_activation_energy", "R2 with temperature"},
    {"tau2_activation_energy", "tau2 with temperature", true},
    {"r3_activation_energy", "R3 with temperature"},
    {"tau3_activation_energy", "tau3 with temperature", true},
    {"r4_activation_energy", "R4 with temperature"},
    {"tau4_activation_energy", "tau4 with temperature", true}}};

}  // namespace

std::vector<LawFact> law_facts(const IdentifyResult& result) {
  constexpr double kTold = 2.0 / 3.0;  // of what was believed before
  constexpr double kJoules = 1e3;
  const ResistanceLaws& laws = result.model.laws;
  const Index model_branches = result.model.branches();
  std::vector<LawFact> out;
  if (!laws.has_temperature() && !laws.has_charge_transfer() && !laws.has_hysteresis()) return out;
  const ResistanceLaws::Packed believed = LawPriors{}.marginal_sigma();
  const bool has_intervals = result.packed.size() > 0 && result.uncertainty.sigma.size() == result.packed.size();
  const auto sigma_of = [&](Index place) {
    if (!has_intervals) return believed(place);
    return result.uncertainty.sigma(result.packed.size() - ResistanceLaws::kCount + place);
  };
  for (Index place = ResistanceLaws::kOhmic; place < ResistanceLaws::resistance(model_branches); ++place) {
    const Energy& energy = kEnergies[static_cast<std::size_t>(place)];
    const double value = laws.packed()(place), sigma = sigma_of(place);
    const bool bounded = !energy.of_tau;
    double low = value - kInterval * sigma;
    if (bounded && low < 0.0) low = 0.0;  // stays no number where there is no interval
    out.push_back({energy.key, energy.label, "J/mol", kJoules * value, kJoules * low,
                   kJoules * (value + kInterval * sigma),
                   sigma < kTold * believed(place) ? FactOrigin::kMeasured : FactOrigin::kAssumed,
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
  if (entropy_sigma < kTold * believed(ResistanceLaws::kEntropy)) {
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
                   sigma < kTold * believed(ResistanceLaws::kLogExchange) ? FactOrigin::kMeasured
                                                                             : FactOrigin::kAssumed});
  }
  VOLTLAP_DEMAND(out.size() > 2 * static_cast<std::size_t>(model_branches));
  return out;
}

LawUnit shown_unit(std::string_view unit) {
  if (unit == "J/mol") return {1e-3, "kJ/mol"};
  if (unit == "V/K" || unit == "V") return {1e3, "m" + std::string(unit)};
  return {1.0, std::string(unit)};
}

std::string law_interval(const LawFact& fact) {
  const double scale = shown_unit(fact.unit).scale;
  return interval_words(scale * fact.ci95_low, scale * fact.ci95_high);
}

std::string law_origin(const std::vector<LawFact>& facts, std::string_view key) {
  for (const LawFact& fact : facts) {
    if (fact.key != key) continue;
    const bool settled = std::isfinite(fact.ci95_low) && std::isfinite(fact.ci95_high);
    return fmt::format("{}, {}{}", fact.origin == FactOrigin::kMeasured ? "identified" : "assumed", law_interval(fact),
                       settled ? " " + shown_unit(fact.unit).unit : "");
  }
  return "assumed";
}

std::string laws_text(const IdentifyResult& result) {
  std::string out;
  for (const LawFact& fact : law_facts(result)) {
    const LawUnit shown_in = shown_unit(fact.unit);
    out += fmt::format("  {:<21} {:>9} {:<6} {:<9} {}{}\n", fact.label, short_number(shown_in.scale * fact.value),
                       shown_in.unit, name_of(fact.origin), law_interval(fact), fact.at_bound ? ", at its bound" : "");
  }
  return out;
}

}  // namespace voltlap::plant
