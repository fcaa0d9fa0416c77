// SPDX-License-Identifier: Apache-2.0
// Resistance of a cell from the table of the configuration, over state of charge and temperature.
#pragma once
#include "base/units.hpp"
#include "bms/config.hpp"
#include "bms/estimate/soc_estimator.hpp"

namespace voltlap::bms {

/// R(soc) (1 + k (T - T_ref)), never below a fifth of R(soc) nor above five times it. Without a state of charge the
/// highest resistance of the table stands for every one.
[[nodiscard]] Resistance cell_resistance(const ResistanceTable& table, const SocEstimate& soc, Temperature temperature);

}  // namespace voltlap::bms
