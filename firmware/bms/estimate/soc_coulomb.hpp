// SPDX-License-Identifier: Apache-2.0
// State of charge by counting charge from a start at the open-circuit voltage.
//   start:  SOC_0 = mean over the cells of OCV^-1(V_cell), at the first step with every cell good and |I| small
//   after:  q_k = q_{k-1} - (I_{k-1} + I_k) / 2 * (t_k - t_{k-1}),  SOC = q / capacity
// It counts five points beyond either end and no further, reported within 0 and 1.
// q in half mA ms, so that the trapezoid is exact in integers and nothing drifts by truncation.
#pragma once
#include "bms/estimate/soc_estimator.hpp"

namespace voltlap::bms {

void soc_coulomb(const Config& config, const SocInput& input, SocEstimate& state);

/// Cells that count as at rest: a good sample of at most Config::soc_start_current either way.
[[nodiscard]] bool at_rest(const Config& config, const Sample<Current>& current);

/// BMS-087. The charge up to a new sample, by the trapezoid; false where there is none. A gap is bridged between its
/// two ends for as long as the contactors can have been closed without a measurement (Config::measurement_lost_time);
/// of a longer one the current before it counts for that time, and no more.
bool count_charge(const Config& config, const Sample<Current>& current, SocEstimate& state);

/// BMS-089. Anew from cells at rest, for what their shunts took flowed through no sensor; not where the curve is so
/// flat that 1.5 mV are half a point. Only for a count: a filter has seen the same voltages.
void recount_at_rest(const Config& config, const CellVoltage* cells, SocEstimate& state);

/// Mean over the cells of the SOC that belongs to each voltage at rest.
[[nodiscard]] Soc soc_from_ocv(const Config& config, const Sample<CellVoltage>* cells);

}  // namespace voltlap::bms
