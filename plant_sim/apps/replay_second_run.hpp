// SPDX-License-Identifier: Apache-2.0
// A replayed log once more: with other settings, or by the firmware of another commit.
#pragma once
#include <string>
#include <vector>

#include "apps/replay_run.hpp"

namespace voltlap::plant {

/// With further settings; `first` is the run without them, and what changes leads away from it.
[[nodiscard]] SecondRun run_with(const ReplayAsked& asked, const std::vector<std::string>& settings,
                                 const MapFinding& finding, const DataFolder& data, const ReplayResult& first);

/// By this program over the folders firmware/ and can_dbc/ of a commit of this checkout, which is built where it is not
/// yet; what changes leads from that firmware to this one. Throws InputError where the commit is not known, or its
/// firmware does not fit this program.
[[nodiscard]] SecondRun run_by_commit(const ReplayAsked& asked, const std::string& commit, const MapFinding& finding,
                                      const ReplayResult& present);

}  // namespace voltlap::plant
