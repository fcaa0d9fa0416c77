// SPDX-License-Identifier: Apache-2.0
// A thermometer in whole degrees hides what a pulse does: 1 K is 2 % of every resistance, 5 mV of 400 A. Between its
// steps the cell's own heat tells the temperature:
//
//   T = b(t) + k h(t),   dh/dt = I^2 - h / tau        b: straight between a few knots; k >= 0
//
// fitted to readings of which each only says T +- half a step: a reading is replaced by the point of its band nearest
// to the curve until both stand still.
#pragma once
#include "io/logs/cell_log.hpp"

namespace voltlap::plant {

/// Replaces readings in coarse steps (0.2 K or more) by the curve where it keeps to their bands, and says so among the
/// log's repairs; else leaves them.
void smooth_quantised_temperature(CellLog& log);

}  // namespace voltlap::plant
