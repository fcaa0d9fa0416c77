// SPDX-License-Identifier: Apache-2.0
// The tables of a cell file by name, and what is done to a whole one: the parameters of reference study, 2016,
// Tables 7.1 to 7.3.
#pragma once
#include <array>
#include <vector>

#include "core/parameters.hpp"

namespace voltlap::plant {

enum class TableParameter { kEm, kR0, kR1, kR2, kR3, kR4, kTau1, kTau2, kTau3, kTau4 };
[[nodiscard]] constexpr const char* name_of(TableParameter parameter) {
  constexpr std::array kNames{"em", "r0", "r1", "r2", "r3", "r4", "tau1", "tau2", "tau3", "tau4"};
  return kNames[static_cast<std::size_t>(parameter)];
}

/// Those that a cell has: Em, R0, R and then tau of its branches.
[[nodiscard]] std::vector<TableParameter> table_parameters(const CellParameters& cell);

enum class TableAxis { kTemperature, kCurrent };

/// Values at the breakpoints, [soc][temperature][current]; of Em empty where the cell file has its OCV over SOC
/// alone.
[[nodiscard]] std::vector<double> table_of(const CellParameters& cell, TableParameter parameter);

/// The cell with another table of `parameter`.
void set_table(CellParameters& cell, TableParameter parameter, std::vector<double> table);

}  // namespace voltlap::plant
