// SPDX-License-Identifier: Apache-2.0
// The result of an endurance as one JSON object: numbers, hashes, and all that is needed to repeat the run.
#pragma once
#include <string>
#include <vector>

#include "io/bus/bus_facts.hpp"
#include "io/bus/bus_load.hpp"
#include "io/bus/trace_hash.hpp"
#include "race/endurance.hpp"

namespace voltlap::plant {

/// What was asked for, in the words of the command line.
struct RunDescription {
  std::string vehicle{};
  std::string course{};     ///< a track, or a recorded drive
  std::string lap_start{};  ///< flying | standing | drive
  std::string cells{};      ///< all | representative
  std::vector<std::string> settings{};
  std::uint64_t seed = 0;
  int laps = 0;
};

/// JSON text with a final newline. `wall_s` is the real time that the run took, `bus` what the interface was like, `load`
/// how full it was when that was counted.
[[nodiscard]] std::string run_result_json(const RunDescription& run, const VehicleParameters& car,
                                          const EnduranceResult& result, const TraceHash::Result& hash, double wall_s,
                                          const BusFacts* bus = nullptr, const BusLoadResult* load = nullptr);

}  // namespace voltlap::plant
