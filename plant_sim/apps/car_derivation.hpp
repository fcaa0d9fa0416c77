// SPDX-License-Identifier: Apache-2.0
// What follows for a car when its pack, motor or mass becomes another: rules of thumb, each with its reason.
#pragma once
#include <set>
#include <string>
#include <vector>

#include "core/parameters.hpp"

namespace voltlap::plant {

/// A number that nobody gave and that must not stay the other car's.
struct DerivedNumber {
  std::string key;
  std::string value;  ///< as in TOML
  std::string why;
};

/// The keys that the team gave itself: what follows never takes their place.
using GivenKeys = std::set<std::string, std::less<>>;

/// Mass without the pack, from the scales (with pack, without driver) or, at 0, from the car that was taken.
/// Throws InputError for a car that is lighter than its pack.
[[nodiscard]] std::vector<DerivedNumber> derive_mass(const VehicleParameters& base, const VehicleParameters& car,
                                                     const GivenKeys& given, double on_scales_kg);

/// Limits, sensors, DC link and losses that fit `car`, where its pack, motor or mass is not that of `base`. The mass of
/// `car` is derived already.
[[nodiscard]] std::vector<DerivedNumber> derive_fittings(const VehicleParameters& base, const VehicleParameters& car,
                                                         const GivenKeys& given);

}  // namespace voltlap::plant
