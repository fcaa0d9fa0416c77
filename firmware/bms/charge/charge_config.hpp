// SPDX-License-Identifier: Apache-2.0
// What follows from a configuration for the charge: the voltage that the highest cell is charged to, and the bounds
// that the charger itself is told.
#pragma once
#include "bms/config.hpp"

namespace voltlap::bms {

inline constexpr Current kChargerStep = Current::from_raw(100);              // of ChargerCommand in charger.dbc
inline constexpr PackVoltage kChargerVoltageStep = PackVoltage::from_raw(1'000);  // the same: 0.1 V

/// The highest cell is full when it stands here at the end current. Its OCV is then that of a full cell, or it stands a
/// margin for the channel's error below its greatest voltage. A flat curve counts as full at its end, not on the way.
[[nodiscard]] constexpr CellVoltage charge_voltage(const Config& c) {
  const std::int64_t end_nv =
      std::int64_t{c.charge_current_end.raw()} * c.resistance.resistance[c.resistance.count - 1].raw();
  const CellVoltage full = c.ocv.voltage[c.ocv.count - 1] + CellVoltage::saturated(end_nv / 100'000);
  return min(c.cell_voltage_max - c.charge_margin, full);
}

/// A second bound, in the charger: every cell at its greatest voltage. Rounded up, so that it never holds a pack of few
/// cells below what the BMS steers.
[[nodiscard]] constexpr PackVoltage charger_voltage_max(const Config& c) {
  const std::int64_t all = std::int64_t{c.cell_voltage_max.raw()} * c.cells_in_series;
  const std::int64_t step = kChargerVoltageStep.raw();
  return PackVoltage::saturated((all + step - 1) / step * step);
}

}  // namespace voltlap::bms
