// SPDX-License-Identifier: Apache-2.0
#include "race/sensors/sensors.hpp"

#include <cmath>

namespace voltlap::plant {

double Sensors::current(double truth_a) {
  const bool fine = std::abs(truth_a) <= section_.current_low_range_a;
  return read(truth_a, fine ? section_.current_low_noise_a : section_.current_high_noise_a,
              fine ? section_.current_low_step_a : section_.current_high_step_a);
}

double Sensors::read(double truth, double noise, double step) {
  double value = truth;
  if (section_.noise) value += noise * normal_(random_);
  if (section_.quantisation && step > 0.0) value = step * std::round(value / step);
  return value;
}

}  // namespace voltlap::plant
