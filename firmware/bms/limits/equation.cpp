// SPDX-License-Identifier: Apache-2.0
#include "bms/limits/equation.hpp"

namespace voltlap::bms {
namespace {

using can::LimitReason;

/// V / R in mA, rounded down: 0.1 mV / 1 uOhm is 100 A, that is 100'000 mA.
Current over_resistance(CellVoltage voltage, Resistance resistance) {
  const std::int64_t numerator = std::int64_t{voltage.raw()} * 100'000;
  const std::int64_t denominator = resistance.raw();
  const std::int64_t quotient = numerator / denominator;
  return Current::saturated(numerator % denominator < 0 ? quotient - 1 : quotient);
}

}  // namespace

// BMS-040: no cell below its minimum voltage.
void lower_discharge_by_equation(const Config& config, const State& s, Limit& limit) {
  for (std::uint16_t k = 0; k < config.cells_in_series; ++k) {
    const CellVoltage margin = s.measured.cell[k].value - config.cell_voltage_min;
    lower(limit, s.measured.cell_current[k] + over_resistance(margin, s.cell_resistance), LimitReason::kCellVoltage,
          static_cast<std::uint8_t>(k));
  }
}

// BMS-041: no cell above its maximum voltage.
void lower_charge_by_equation(const Config& config, const State& s, Limit& limit) {
  for (std::uint16_t k = 0; k < config.cells_in_series; ++k) {
    const CellVoltage margin = config.cell_voltage_max - s.measured.cell[k].value;
    lower(limit, over_resistance(margin, s.cell_resistance) - s.measured.cell_current[k], LimitReason::kCellVoltage,
          static_cast<std::uint8_t>(k));
  }
}

}  // namespace voltlap::bms
