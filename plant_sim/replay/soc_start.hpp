// SPDX-License-Identifier: Apache-2.0
// Where the firmware's SOC starts in a recording that begins under load: cells that sag say little of their charge.
#pragma once
#include <string>

#include "replay/role_inputs.hpp"

namespace voltlap::plant {

struct SocStart {
  double soc = kUnknown;
  SocSource source = SocSource::kUnloaded;
  std::string said{};  ///< for a person: from what, and what it may be wrong by
};

/// At `begin_s`, the best that there is of:
///   the first later rest of a minute, by the open-circuit voltage there, and the charge between;
///   the log's own SOC, unless it jumps (`soc_jumps`), or where the voltage of that rest says little;
///   the cells' voltage with what they sag by the firmware's resistance.
/// `car.ocv` and `car.capacity_ah` are known.
[[nodiscard]] SocStart soc_under_load(const DriveLog& log, const ReplayCar& car, double begin_s, bool soc_jumps);

[[nodiscard]] double ocv_of_soc(const ReplayCar& car, double soc);
[[nodiscard]] double soc_of_ocv(const ReplayCar& car, double voltage_v);

}  // namespace voltlap::plant
