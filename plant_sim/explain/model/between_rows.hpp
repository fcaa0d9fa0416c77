// SPDX-License-Identifier: Apache-2.0
// What a log does not say between its rows.
#pragma once
#include "explain/model/observed.hpp"

namespace voltlap::explain {

/// What predictions are off for the rows that were not recorded, by how much they would be others without half of the
/// rows: at most that, where a load goes on and off, and a third of it where it is smooth. The mean of either half:
/// pulses that all begin in an odd row and end in an even one would be longer each, and count a charge that no row
/// between the rows could.
void put_between_rows(Observed& log);

}  // namespace voltlap::explain
