// SPDX-License-Identifier: Apache-2.0
// The current and the voltage of the battery among the signals of a recording.
#pragma once
#include <string>
#include <vector>

#include "io/logs/map_proposal.hpp"
#include "io/logs/signal_candidate.hpp"

namespace voltlap::plant {

struct BatteryPair {
  std::vector<ProposedRole> roles;  ///< current, voltage or pack_voltage, bus_voltage: as far as they are clear
  std::vector<OpenChoice> open;     ///< the needed ones that are not
  std::vector<const RecordedSignal*> taken;
  const RecordedSignal *current = nullptr, *voltage = nullptr;  ///< of the roles; nullptr while open
  bool is_clear = false;                                        ///< the voltage answers to the current
};

[[nodiscard]] BatteryPair choose_battery_pair(const RecordedSignals& recording,
                                              const std::vector<SignalCandidate>& all);

/// Units in which a clock without one could count, from the battery: R I over the fall of the open circuit voltage
/// with the charge is a time, of 20 s to 40 min for lithium cells.
struct TimeUnits {
  std::vector<std::string> possible;  ///< of s, ms, min, h; one: it is that; empty: nothing is known
  std::string why;
};
[[nodiscard]] TimeUnits time_units(const RecordedSignals& recording, const RecordedSignal& clock,
                                   const BatteryPair& pair);

/// Whether a clock that would count seconds cannot: in seconds the charge of the log would have moved the voltage by
/// far, whatever the cell, and has not.
[[nodiscard]] bool is_in_milliseconds(const RecordedSignal& clock, const RecordedSignal& current,
                                      const RecordedSignal& voltage);

}  // namespace voltlap::plant
