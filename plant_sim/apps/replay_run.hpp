// SPDX-License-Identifier: Apache-2.0
// One log through the firmware, as the command line asks for it.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "apps/map_finding.hpp"
#include "core/parameter_file.hpp"
#include "replay/replay_result.hpp"

namespace voltlap::plant {

struct ReplayAsked {
  std::string log{}, map{}, pack{};  ///< map, pack: name or path, empty where none is given
  std::vector<std::string> settings{};
};

/// Adds --set.
void add_settings(CLI::App& command, ReplayAsked& asked);

/// A recording of our own bus without a map.
[[nodiscard]] bool is_replayed_by_frame(const ReplayAsked& asked, const MapFinding& finding);

/// By role, whatever bus it is of. `progress` is told what is done, from 0 to 1; from one half on the log itself is no
/// longer read.
[[nodiscard]] ReplayResult replay_by_role(const ReplayAsked& asked, const MapFinding& finding, const DataFolder& data,
                                          const std::function<void(const std::string&, double)>& progress);

/// Frame by frame or by role. Throws InputError for what cannot be replayed, with why.
[[nodiscard]] ReplayResult run_replay(const ReplayAsked& asked, const MapFinding& finding, const DataFolder& data);

}  // namespace voltlap::plant
