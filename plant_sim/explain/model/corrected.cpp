// SPDX-License-Identifier: Apache-2.0
#include "explain/model/corrected.hpp"

namespace voltlap::explain {

plant::Recording corrected(plant::Recording log, const std::vector<MemberEffect>& effects) {
  for (const MemberEffect& effect : effects) {
    VectorXd& values = log.signals.at(effect.role);
    const auto read = log.read_s.find(effect.role);
    // A reading has the effect of the time it was made at.
    const VectorXd at = read == log.read_s.end() ? log.time_s : read->second;
    VectorXd held(values.size());
    Index row = 0;
    for (Index k = 0; k < values.size(); ++k) {
      while (row + 1 < values.size() && log.time_s(row + 1) <= at(k)) ++row;
      while (row > 0 && log.time_s(row) > at(k)) --row;
      held(k) = effect.by_row(row);
    }
    values -= held;
    const bool of_pack = effect.role.starts_with("cell_voltage_") && !effect.of_sensor;
    if (!of_pack) continue;
    for (const char* role : {"pack_voltage", "bus_voltage"}) {
      if (const auto pack = log.signals.find(role); pack != log.signals.end()) pack->second -= effect.by_row;
    }
  }
  return log;
}

}  // namespace voltlap::explain
