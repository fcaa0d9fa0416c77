// SPDX-License-Identifier: Apache-2.0
// What a log does not say between its rows.
#pragma once
#include "explain/model/observed.hpp"

namespace voltlap::explain {

/// Does the current change so much from row to row that what flowed between them may be anything? Then the charge
/// and the lags that a model makes of the rows are off as well.
[[nodiscard]] bool is_between_rows(const plant::Comparison& log);

/// A cell alone: what a cycler does to it in a laboratory it does from row to row.
[[nodiscard]] bool is_of_laboratory(const plant::Recording& log);

/// What predictions are off for the rows that were not recorded, by how much they would be others without half of the
/// rows: at most that, where a load goes on and off, and a third of it where it is smooth. Not what one half has slowly
/// more than the other: pulses that all begin in an odd row and end in an even one would be longer each, and count a
/// charge that no row between the rows could.
void put_between_rows(Observed& log);

}  // namespace voltlap::explain
