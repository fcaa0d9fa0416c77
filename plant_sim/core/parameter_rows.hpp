// SPDX-License-Identifier: Apache-2.0
// What the files of rows share: the way to a field, and the rows of each.
#pragma once
#include <span>

#include "core/parameter_table.hpp"

namespace voltlap::plant {

template <auto Section, auto Field>
constexpr auto at = +[](VehicleParameters& car) -> auto& { return car.*Section.*Field; };
template <auto Map, auto Field>
constexpr auto map = +[](VehicleParameters& car) -> auto& { return car.cell.*Map.*Field; };
template <std::size_t Branch, auto Map, auto Field>
constexpr auto branch = +[](VehicleParameters& car) -> auto& { return car.cell.branches[Branch].*Map.*Field; };

[[nodiscard]] std::span<const ParameterRow> car_parameter_rows();       ///< parameter_definitions.cpp
[[nodiscard]] std::span<const ParameterRow> cell_parameter_rows();      ///< cell_parameter_definitions.cpp
[[nodiscard]] std::span<const ParameterRow> instrument_parameter_rows();  ///< instrument_parameter_definitions.cpp
[[nodiscard]] std::span<const IndexedRow> cell_variation_rows();
[[nodiscard]] std::span<const IndexedRow> instrument_channel_rows();
[[nodiscard]] std::span<const ParameterRow> firmware_parameter_rows();  ///< firmware_parameter_definitions.cpp

}  // namespace voltlap::plant
