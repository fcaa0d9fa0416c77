// SPDX-License-Identifier: Apache-2.0
// Every variant of the car's model, and a drive that puts each of them through traction, rest, brakes and regeneration.
#pragma once
#include <string>
#include <vector>

#include "car/car.hpp"
#include "core/parameters.hpp"

namespace voltlap::plant::test {

struct Variant {
  std::string name;
  VehicleParameters car;
  bool representative = false;
};

[[nodiscard]] std::vector<Variant> all_variants();

/// A car under prescribed phase current and brake pedal, in control periods of 10 ms.
class Drive {
 public:
  explicit Drive(const Variant& variant, int steps_per_period = 10);

  /// Closes the contactors over the precharge resistor; 0.7 s.
  void switch_on();
  void run(double seconds, double phase_current_a, double brake);
  /// 2 s of traction, 0.3 s of rest, 1 s of regeneration, 1 s of half brake.
  void mixed();

  Car car;

 private:
  int steps_;
};

}  // namespace voltlap::plant::test
