// SPDX-License-Identifier: Apache-2.0
// What the bus of a run was like, beside the frames that the car sent.
#pragma once
#include <cstdint>
#include <string>

namespace voltlap::plant {

struct BusStatistics {
  std::string interface{}, pacing{};  ///< pacing: lockstep | realtime
  std::uint64_t foreign_frames = 0;   ///< not of this bus, or of the plant's ids and not by the plant
  std::uint64_t missing_frames = 0;   ///< announced by the control units and not seen
  std::uint64_t dropped_frames = 0;   ///< this process did not read in time
  std::uint64_t error_frames = 0, send_retries = 0;
  std::uint64_t late_steps = 0;  ///< --realtime: began more than half a period late
  double late_worst_s = 0.0;
};

}  // namespace voltlap::plant
