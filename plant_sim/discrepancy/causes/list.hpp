// SPDX-License-Identifier: Apache-2.0
// The catalogue: every cause that regression can name. A new one is its file and its row here.
#pragma once
#include <vector>

#include "discrepancy/cause.hpp"

// clang-format off
#define VOLTLAP_CAUSES(X) \
  X(series_resistance) \
  X(polarization_resistance) \
  X(slow_relaxation) \
  X(resistance_temperature) \
  X(resistance_current) \
  X(resistance_soc) \
  X(hysteresis) \
  X(ocv_shape) \
  X(capacity) \
  X(initial_soc) \
  X(self_discharge) \
  X(weak_cell) \
  X(contact_resistance) \
  X(reported_voltage_compensation) \
  X(current_gain) \
  X(current_offset) \
  X(current_saturation) \
  X(voltage_gain) \
  X(voltage_offset) \
  X(time_skew) \
  X(entropic_heat) \
  X(cooling) \
  X(cooling_at_stop) \
  X(heat_capacity) \
  X(neighbour_heat) \
  X(ambient) \
  X(thermistor_lag) \
  X(thermistor_offset) \
  X(auxiliary_load) \
  X(inverter_efficiency) \
  X(motor_constant) \
  X(field_weakening) \
  X(motor_temperature) \
  X(drag_area) \
  X(rolling_resistance) \
  X(mass) \
  X(tyre_radius) \
  X(tyre_slip) \
  X(grip) \
  X(grade) \
  X(wind) \
  X(brake_fade) \
  X(regen_split)
// clang-format on

namespace voltlap::plant {

#define VOLTLAP_DECLARE(name) [[nodiscard]] Cause name();
VOLTLAP_CAUSES(VOLTLAP_DECLARE)
#undef VOLTLAP_DECLARE

/// All causes, without those named in `without`. Throws InputError for a name that is none.
[[nodiscard]] std::vector<Cause> catalogue(const std::vector<std::string>& without);

/// Typical sizes for this cell: those of resistances grow with its own.
void size_for(const CellParameters& cell, std::vector<Cause>& causes);

}  // namespace voltlap::plant
