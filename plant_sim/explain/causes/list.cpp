// SPDX-License-Identifier: Apache-2.0
#include "explain/causes/list.hpp"

#include <algorithm>

#include "car/battery/cell_tables.hpp"
#include "core/errors.hpp"

namespace voltlap::plant {

double cold_resistance(const CellParameters& cell) {
  constexpr double kColder_k = 20.0, kSoc = 0.5;
  const CircuitParameters circuit =
      CellTables(cell).circuit(kSoc, cell.reference_temperature_c - kColder_k, cell.reference_current_a);
  double out = circuit.r0_ohm;
  for (std::size_t b = 0; b < cell.branch_count(); ++b) out += circuit.r_ohm[b];
  return out;
}

std::vector<Cause> catalogue(const std::vector<std::string>& without) {
  std::vector<Cause> all;
#define VOLTLAP_ADD(name) all.push_back(name());
  VOLTLAP_CAUSES(VOLTLAP_ADD)
#undef VOLTLAP_ADD
  std::stable_sort(all.begin(), all.end(), [](const Cause& a, const Cause& b) { return a.balance < b.balance; });
  for (const std::string& name : without) {
    const auto found = std::find_if(all.begin(), all.end(), [&](const Cause& cause) { return cause.name == name; });
    if (found == all.end()) {
      throw InputError("--set explain.without", "\"" + name + "\"", "the name of a cause that regression can find",
                       "docs/explain.md lists them");
    }
    all.erase(found);
  }
  return all;
}

void size_for(const CellParameters& cell, std::vector<Cause>& causes) {
  constexpr double kHalfFull = 0.5;
  const double ohm =
      CellTables(cell).circuit(kHalfFull, cell.reference_temperature_c, cell.reference_current_a).r0_ohm;
  for (Cause& cause : causes) {
    for (CauseParameter& p : cause.parameters) {
      if (p.of_cell) p.typical *= std::max(1.0, ohm / kUsualOhm);
    }
    // Of what a cell can only have more of, a change takes away at most what the model has.
    if (cause.present) cause.parameters[0].low = -cause.present(cell);
  }
}

}  // namespace voltlap::plant
