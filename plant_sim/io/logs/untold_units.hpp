// SPDX-License-Identifier: Apache-2.0
// Units that nobody told, of a table whose columns were recognised by their names: found from the numbers where those
// are no car's, and said. What is told is never changed here.
#pragma once
#include "io/logs/recorded_signals.hpp"
#include "io/logs/role_map.hpp"

namespace voltlap::plant {

/// Time: since 1970 in ms, us or ns; days of a spreadsheet; ms where the battery rules seconds out; else seconds.
/// Currents that no car carries, and those for which a cell would have no resistance, are in mA, voltages beyond any
/// car's in mV. A date written as one number is refused (InputError).
void settle_untold_units(const RecordedSignals& table, RoleMap& map);

}  // namespace voltlap::plant
