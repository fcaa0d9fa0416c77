// SPDX-License-Identifier: Apache-2.0
// The laws over temperature and current of an identified cell, for a reader: each with its interval, and whether the
// recordings told it or it is assumed (circuit/resistance_laws.hpp).
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "learn/identify/identify.hpp"
#include "learn/identify/result/cell_body.hpp"

namespace voltlap::plant {

struct LawFact {
  std::string_view key, label, unit;
  double value = 0.0, ci95_low = 0.0, ci95_high = 0.0;
  FactOrigin origin = FactOrigin::kAssumed;
  bool at_bound = false;  ///< 0, of an energy with which a resistance falls: less is no cell
};

/// Energies of R0, of each branch's resistance and time constant; the exchange current where there is a
/// charge transfer. Empty where the laws are switched off. A law counts as measured when the recordings leave less than
/// two thirds of what was believed of it before.
[[nodiscard]] std::vector<LawFact> law_facts(const IdentifyResult& result);

/// The unit in which a number of a law has few digits before its point: kJ/mol, mV/K, mV.
struct LawUnit {
  double scale = 1.0;
  std::string unit;
};
[[nodiscard]] LawUnit shown_unit(std::string_view unit);

/// "0.4 to 39.6" in that unit; "not settled" where the fit gives no interval.
[[nodiscard]] std::string law_interval(const LawFact& fact);

/// "identified, 18.2 to 21.4 kJ/mol", "assumed, not settled": of the fact with that key.
[[nodiscard]] std::string law_origin(const std::vector<LawFact>& facts, std::string_view key);

/// For a person, a line each.
[[nodiscard]] std::string laws_text(const IdentifyResult& result);

}  // namespace voltlap::plant
