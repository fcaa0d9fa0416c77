// SPDX-License-Identifier: Apache-2.0
// One parameter of a cell file, written as a curve over SOC with its laws or as a table, as the table of all points.
//
//   p(s, T, I) = value(s) (1 + per_kelvin (T - T_ref)) exp(Ea/Rg (1/T - 1/T_ref)) (1 + per_ampere (I - I_ref))
//   R0           plus v_ct(I) / I with the exchange current of its law             car/battery/cell_effects.hpp
#pragma once
#include <string>
#include <vector>

#include "core/parameters.hpp"

namespace voltlap::plant {

/// Where a field of a cell stands, for messages.
[[nodiscard]] std::string place_in(const CellParameters& cell, const std::string& field);

/// Throws InputError for an empty list, or one that does not rise.
void require_increasing(const CellParameters& cell, const char* key, const std::vector<double>& values);

/// Of a charge transfer that is given by its law [A].
[[nodiscard]] double exchange_current_of(const CellParameters& cell, double temperature_c);

/// One parameter as a full table [soc][temperature][current]. Throws InputError for a size that does not fit and for
/// a value that is not more than 0.
[[nodiscard]] std::vector<double> expand(const CellParameters& cell, const std::string& key,
                                         const CellParameterMap& map);

}  // namespace voltlap::plant
