// SPDX-License-Identifier: Apache-2.0
// What keeps and sheds a cell's heat: mass, size and what follows of them. Recordings of current and voltage do not
// tell it. It is told by the person who has the cell on the table, or assumed of a cell of that form, and says which.
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/parameters.hpp"
#include "learn/identify/preparation/capacity.hpp"
#include "learn/identify/result/cell_form.hpp"

namespace voltlap::plant {

enum class FactOrigin { kTold, kMeasured, kAssumed };
[[nodiscard]] std::string_view name_of(FactOrigin origin);

/// A number of a cell file, and where it is from.
struct CellFact {
  std::string_view key, label, unit;
  double value = 0.0;
  FactOrigin origin = FactOrigin::kAssumed;
  std::string source;
};

/// By the flags; empty: assumed.
struct ToldBody {
  std::optional<double> mass_kg;
  std::optional<CellForm> form;
  std::optional<double> heat_capacity_j_per_kg_k;
};

struct CellBody {
  std::optional<CellForm> form;  ///< empty: a pouch of which only the surface is assumed
  FactOrigin form_origin = FactOrigin::kAssumed;
  std::string form_source;
  CellFact capacity, mass, heat_capacity, surface, convection, surface_lag;
  bool capacity_is_lower_bound = false;  ///< only what was drawn

  /// "21700, a cylinder of 21.7 mm x 70.2 mm", "a pouch".
  [[nodiscard]] std::string form_text() const;
  void write_into(CellParameters& cell) const;
};

/// What was not told fits the form: that of the size, else of the mass, else of the capacity; of one that is only what
/// was drawn, as the smallest that the cell can have. `shipped` loads a cell of data/cells by its name.
[[nodiscard]] CellBody cell_body(const ToldBody& told, const Capacity& capacity,
                                 const std::function<CellParameters(const std::string& name)>& shipped);

/// Energy by the open-circuit voltage over mass.
[[nodiscard]] double specific_energy_wh_per_kg(const CellParameters& cell);

/// Throws InputError where the size that was told holds several times the energy of the best cells: then the current's
/// unit, --cells-in-parallel or the size is wrong.
void require_possible_size(const CellParameters& cell, const CellBody& body);

/// A density, a specific energy or one per volume that no such cell has, each in a sentence.
[[nodiscard]] std::vector<std::string> implausible(const CellParameters& cell, const CellBody& body);

/// Every single number of a cell file, in its order. `temperature_told`: that of the recordings.
[[nodiscard]] std::vector<CellFact> cell_facts(const CellParameters& cell, const CellBody& body, bool temperature_told);

/// For a person: form and facts, a line each; which flags would tell what is assumed.
[[nodiscard]] std::string cell_facts_text(const CellParameters& cell, const CellBody& body, bool temperature_told);

}  // namespace voltlap::plant
