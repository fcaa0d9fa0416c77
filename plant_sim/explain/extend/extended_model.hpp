// SPDX-License-Identifier: Apache-2.0
// The model with its causes as a file of the kind that was given, which every command takes.
//
// What the world of a log knows and a car file says in its own words:
//   contact        battery.contact_resistance_ohm += R, where the sum is positive
//   tyre slip x    stiffness/(1 + x): tyres.pacejka_b/(1 + x)
//   grip x         tyres.pacejka_d times (1 + x)
//   inverter x     losses times (1 + x): 1/eta - 1 = (1 + x)(1/eta_0 - 1)
//   torque x       motor.constant_nm_per_a (1 + x)
//   base speed x   motor.curve_speed_rpm (1 + x)
// Errors of sensors and where a log began are no part of a car.
#pragma once
#include <string>
#include <vector>

#include "explain/balances/model.hpp"

namespace voltlap::plant {

struct ExtendedCar {
  VehicleParameters car;
  std::vector<std::string> left_out;  ///< what the simulated car has no parameter for, in words
};
[[nodiscard]] ExtendedCar extended_car(const World& given, const World& extended);

/// TOML of the model at `model.path` with what `car` changes; empty when nothing of it changes (a cause in a
/// sensor; one cell of a cell file). A vehicle is written as one built on the given file.
[[nodiscard]] std::string extended_model_toml(const Model& model, const VehicleParameters& car,
                                              const std::string& why);

}  // namespace voltlap::plant
