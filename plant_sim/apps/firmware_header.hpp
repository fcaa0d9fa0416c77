// SPDX-License-Identifier: Apache-2.0
// The BMS's configuration as a C++ header that an image compiles: constant, in the firmware's integers, checked by
// static_assert.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

#include "apps/firmware_config.hpp"
#include "car/battery/branch_reduction.hpp"

namespace voltlap::plant {

/// What the header says of itself.
struct HeaderSource {
  std::string version, command;  ///< the command line that makes it again
};

/// A configuration in a number that is not 0: of the values that an image has, and of nothing else. The header has it,
/// the image gets it from there, and `voltlap flash` and `--ecu` compare it.
[[nodiscard]] std::uint32_t configuration_number(const bms::Config& config);
[[nodiscard]] std::uint32_t number_of_text(std::string_view text);

/// As C++.
[[nodiscard]] const char* protocol_name(InverterProtocol protocol);

/// The car and the number of its configuration as C++: k<kind>Car, k<kind>Number.
[[nodiscard]] std::string owner_lines(const char* kind, const std::string& car, std::uint32_t number);

/// The whole header; the same configuration gives the same bytes. It defines voltlap::bms::kPackConfig, and beside it
/// the circuit of two branches for a filter: the configuration holds its whole resistance alone.
[[nodiscard]] std::string firmware_header(const VehicleParameters& car, const bms::Config& config,
                                          const TableRounding& rounding, const BranchReduction& reduction,
                                          const HeaderSource& source);

/// The cell with the two branches that a filter keeps, at the SOC of the configuration's resistances.
[[nodiscard]] BranchReduction two_branch_tables(const VehicleParameters& car, const bms::Config& config);

/// How many branches the cell has, and what two of them cost, in a sentence of a line.
[[nodiscard]] std::string branches_text(const VehicleParameters& car, const BranchReduction& reduction);

/// How far the tables are from the cell file, in sentences of a line each.
[[nodiscard]] std::string rounding_text(const bms::Config& config, const TableRounding& rounding);

}  // namespace voltlap::plant
