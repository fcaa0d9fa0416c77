// SPDX-License-Identifier: Apache-2.0
// Units that nobody told, of a table whose columns were recognised by their names: found from the numbers where those
// are no car's, and said. What is told is never changed here.
#pragma once
#include "io/logs/recorded_signals.hpp"
#include "io/logs/role_map.hpp"

namespace voltlap::plant {

/// Time: since 1970 in ms, us or ns; s, ms, min or h by the battery (see time_units). Currents beyond the role's range
/// are in mA, voltages beyond any car's in mV.
void settle_untold_units(const RecordedSignals& table, RoleMap& map);

}  // namespace voltlap::plant
