// SPDX-License-Identifier: Apache-2.0
// Where each number of a car comes from: its place, and what the comment behind it there says.
#pragma once
#include <string>
#include <vector>

#include "core/parameter_file.hpp"

namespace voltlap::plant {

struct ParameterSource {
  std::string key;
  std::string value;  ///< as it would stand in a TOML file
  std::string unit;
  std::string meaning;
  std::string place;   ///< "file:line" without folders, "--set", or "default"
  std::string source;  ///< of a value from a file: its comment behind `unit;`; empty when there is none
};

/// Every key of the car in the order of the tables, single cells included.
[[nodiscard]] std::vector<ParameterSource> parameter_sources(const LoadedVehicle& car);

}  // namespace voltlap::plant
