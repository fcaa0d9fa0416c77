// SPDX-License-Identifier: Apache-2.0
// The accelerator position sensors (APPS) of the pedal box: what each puts out over the pedal's travel.
//   V = V_released + (V_full - V_released) p, p the travel from 0 to 1
#pragma once

namespace voltlap::plant {

/// A straight line between two voltages [V].
struct AppsCurve {
  double released_v = 0.0, full_v = 0.0;

  [[nodiscard]] double voltage(double travel) const { return released_v + (full_v - released_v) * travel; }
};

/// By default those of a bench without a master controller: the example of T.4.2.10, and half its slope. A run has the
/// sensors that its master controller is configured for.
struct PedalSensors {
  AppsCurve apps1{0.5, 4.5}, apps2{0.25, 2.25};
};

}  // namespace voltlap::plant
