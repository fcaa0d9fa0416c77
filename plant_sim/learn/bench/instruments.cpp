// SPDX-License-Identifier: Apache-2.0
#include "learn/bench/instruments.hpp"

#include <cmath>
#include <random>

namespace voltlap::plant {
namespace {

constexpr double kFullScale_v = 5.0;  // of a cell input

/// 0 <= x < 1, the same with every library.
double unit_draw(std::mt19937_64& random) {
  return static_cast<double>(random() >> 11U) * 0x1p-53;
}

double within(std::mt19937_64& random, double bound) {
  return bound * (2.0 * unit_draw(random) - 1.0);
}

}  // namespace

InstrumentErrors draw_errors(const InstrumentSection& section, std::size_t cells, std::uint64_t seed) {
  InstrumentErrors errors;
  errors.cell_offset_v.assign(cells, 0.0);
  errors.cell_gain.assign(cells, 0.0);
  errors.temperature_offset_k.assign(cells, 0.0);
  if (!section.systematic) return errors;
  std::mt19937_64 random(seed);
  for (std::size_t cell = 0; cell < cells; ++cell) {
    errors.cell_offset_v[cell] = within(random, 0.5 * section.cell_error_v);
    errors.cell_gain[cell] = within(random, 0.5 * section.cell_error_v / kFullScale_v);
    errors.temperature_offset_k[cell] = section.temperature_error_k * unit_draw(random);
  }
  errors.current_low_offset_a = within(random, section.current_low_offset_a);
  errors.current_low_gain = within(random, section.current_low_gain);
  errors.current_high_offset_a = within(random, section.current_high_offset_a);
  errors.current_high_gain = within(random, section.current_high_gain);
  return errors;
}

double Instruments::current(double truth_a) {
  const bool fine = std::abs(truth_a) <= low_range_a_;
  const double gain = fine ? errors_.current_low_gain : errors_.current_high_gain;
  const double offset = fine ? errors_.current_low_offset_a : errors_.current_high_offset_a;
  return sensors_.current(truth_a * (1.0 + gain) + offset);
}

}  // namespace voltlap::plant
