// SPDX-License-Identifier: Apache-2.0
// A log by role through the firmware as `voltlap replay` does it: map, pack, configuration, replay, disagreements.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "apps/map_finding.hpp"
#include "core/parameter_file.hpp"
#include "replay/replay_result.hpp"

namespace voltlap::plant {

struct RoleReplayRequest {
  std::string log, map{}, pack{};  ///< map empty: proposed or shipped; pack empty: no cell model
  std::vector<std::string> settings{};
  MapFinding finding{};
};

/// `progress` is told what is done, from 0 to 1; from one half on the log itself is no longer read. Throws InputError
/// where the log cannot be replayed, with the reason.
[[nodiscard]] ReplayResult replay_by_role(const RoleReplayRequest& request, const DataFolder& data,
                                          const std::function<void(const std::string&, double)>& progress);

}  // namespace voltlap::plant
