// SPDX-License-Identifier: Apache-2.0
// A recording of our own bus (can_dbc/car.dbc), fed to the control units as it is: frames of the plant go in at their
// ticks, and what BMS and master controller answer must be what they answered then, byte for byte.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "io/bus/in_process_loop.hpp"
#include "replay/replay_result.hpp"

namespace voltlap::plant {

struct OwnFrame {
  std::uint32_t tick = 0;
  Frame frame{};
};

struct OwnRecording {
  std::string path;
  double origin_s = 0.0;         ///< the recording's clock at tick 0
  std::vector<OwnFrame> frames;  ///< in their order; ticks never decrease
  FrameAccount account{};        ///< frames that are not of this bus are counted here alone
  std::vector<LogDefect> defects;
  std::vector<std::string> notes;
};

/// Whether the first frames of a CAN recording are sealed as ours, the plant's and the control units' among them.
[[nodiscard]] bool is_own_recording(const std::string& path);
[[nodiscard]] OwnRecording read_own_recording(const std::string& path);

/// `result` gets everything but names. `cell_min_v`, `cell_max_v`: the limits of the BMS that answers.
void replay_own(const OwnRecording& recording, Ecus& ecus, double cell_min_v, double cell_max_v, ReplayResult& result);

}  // namespace voltlap::plant
