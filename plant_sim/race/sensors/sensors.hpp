// SPDX-License-Identifier: Apache-2.0
// What the instruments make of the truth: quantisation and noise of an Orion BMS's inputs and of a dual-range Hall
// current sensor (LEM DHAB S/33). Both are off by default; then a reading is the truth.
#pragma once
#include <random>

#include "core/parameters.hpp"

namespace voltlap::plant {

class Sensors {
 public:
  Sensors(const SensorSection& section, std::uint64_t seed) : section_(section), random_(seed) {}

  [[nodiscard]] double cell_voltage(double truth_v) {
    return read(truth_v, section_.cell_noise_v, section_.cell_step_v);
  }
  /// The fine channel serves inside its range, the coarse one outside.
  [[nodiscard]] double current(double truth_a);
  [[nodiscard]] double temperature(double truth_c) {
    return read(truth_c, section_.temperature_noise_k, section_.temperature_step_k);
  }

 private:
  [[nodiscard]] double read(double truth, double noise, double step);

  SensorSection section_;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
};

}  // namespace voltlap::plant
