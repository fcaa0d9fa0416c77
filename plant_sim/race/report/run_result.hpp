// SPDX-License-Identifier: Apache-2.0
// The result of an endurance as one JSON object: numbers, hashes, and all that is needed to repeat the run.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "io/bus/board_account.hpp"
#include "io/bus/bus_statistics.hpp"
#include "io/bus/bus_load.hpp"
#include "io/bus/trace_hash.hpp"
#include "race/endurance.hpp"
#include "race/limit_costs.hpp"
#include "race/report/distance_trace.hpp"

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
  std::optional<double> course_length_m{};  ///< of one lap; none for a recorded drive
  std::optional<double> closing_gap_m{};  ///< from the end of the track to its start; none for a recorded drive
};

/// Firmware that ran in another program, and what that says of itself.
struct EcuResult {
  std::string where{};  ///< qemu | process
  std::string image{};
  BoardAccount board{};
};

/// What it came to.
struct RunOutcome {
  const EnduranceResult& result;
  TraceHash::Result hash;
  double wall_s;                        ///< real time that the run took
  const BusStatistics* bus = nullptr;   ///< none within one process
  const EcuResult* ecu = nullptr;       ///< none when the firmware ran in this process, or on an interface
  const BusLoadResult* load = nullptr;  ///< none when it was not counted
  const std::vector<LimitCost>* limit_costs = nullptr;  ///< none when nobody asked
  const DistanceTrace* trace = nullptr;  ///< none when it was not kept
};

/// The part of it that is of such a firmware, alone, as JSON text with a final newline.
[[nodiscard]] std::string ecu_result_json(const EcuResult& ecu);

/// JSON text with a final newline.
[[nodiscard]] std::string run_result_json(const RunDescription& run, const VehicleParameters& car,
                                          const RunOutcome& outcome);

}  // namespace voltlap::plant
