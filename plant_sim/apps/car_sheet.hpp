// SPDX-License-Identifier: Apache-2.0
// A team's own car as one commented file: the numbers that it knows, those that follow from them, and the rest of
// another car behind `base`.
#pragma once
#include <string>
#include <vector>

#include "apps/car_derivation.hpp"
#include "core/parameter_file.hpp"

namespace voltlap::plant {

struct CarRequest {
  std::string from = "vtm16e";        ///< name of a vehicle, or its path
  double mass_on_scales_kg = 0.0;     ///< with the pack, without driver; 0: that of `from`, with the pack as it becomes
  std::vector<std::string> settings;  ///< key=value, what the team knows
};

struct CarSheet {
  LoadedVehicle car;                   ///< as the file describes it
  std::vector<DerivedNumber> derived;  ///< what nobody gave
  std::size_t numbers = 0;             ///< lines of the file with a value
  std::string text;                    ///< the file
};

/// The car of a request: its settings on `from`, and what follows from them. `file` is where the text will stand; other
/// files that it names are relative to its folder. Throws InputError as load_vehicle does, and for a car that is
/// lighter than its pack. A request of nothing gives the car `from` itself.
[[nodiscard]] CarSheet make_car_sheet(const DataFolder& data, const CarRequest& request, const std::string& file);

}  // namespace voltlap::plant
