// SPDX-License-Identifier: Apache-2.0
// What the bench's instruments make of the truth: noise and steps of the plant's sensors, and what stays wrong all
// day.
//
//   reading = step(truth + truth gain + offset + noise)
//
// gain and offset are drawn once per campaign, evenly within the bounds of the data sheets: one set of instruments.
// Source: reference study, 2016, section 5.2 and Appendix D (Orion BMS; LEM DHAB S/33; thermistors in an ice bath).
#pragma once
#include <cstdint>
#include <vector>

#include "learn/bench/plan.hpp"
#include "race/sensors/sensors.hpp"

namespace voltlap::plant {

/// What is wrong with the instruments of a campaign; all zero without systematic errors.
struct InstrumentErrors {
  std::vector<double> cell_offset_v, cell_gain;
  std::vector<double> temperature_offset_k;
  double current_low_offset_a = 0.0, current_low_gain = 0.0;
  double current_high_offset_a = 0.0, current_high_gain = 0.0;
};

[[nodiscard]] InstrumentErrors draw_errors(const InstrumentSection& section, std::size_t cells, std::uint64_t seed);

class Instruments {
 public:
  Instruments(const InstrumentSection& section, InstrumentErrors errors, std::uint64_t noise_seed)
      : low_range_a_(section.sensors.current_low_range_a),
        errors_(std::move(errors)),
        sensors_(section.sensors, noise_seed) {}

  [[nodiscard]] double cell_voltage(std::size_t cell, double truth_v) {
    return sensors_.cell_voltage(truth_v * (1.0 + errors_.cell_gain[cell]) + errors_.cell_offset_v[cell]);
  }
  [[nodiscard]] double current(double truth_a);
  /// Thermistor n sits on cell n.
  [[nodiscard]] double cell_temperature(std::size_t cell, double truth_c) {
    return sensors_.temperature(truth_c + errors_.temperature_offset_k[cell]);
  }
  [[nodiscard]] double air_temperature(double truth_c) { return sensors_.temperature(truth_c); }

 private:
  double low_range_a_;
  InstrumentErrors errors_;
  Sensors sensors_;
};

}  // namespace voltlap::plant
