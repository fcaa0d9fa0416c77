// SPDX-License-Identifier: Apache-2.0
// voltlap replay FOLDER: each log of a folder through the firmware, one line a log, and what has changed in each since an
// earlier time.
#pragma once
#include <cstdio>
#include <functional>
#include <string>

#include "replay/replay_result.hpp"

namespace voltlap::plant {

struct Season {
  std::string folder;                     ///< with its folders; names that begin with a dot are left out
  std::string json_folder, baseline_folder;  ///< of one JSON a log, at the log's own path; empty: none
  std::function<ReplayResult(const std::string& log)> replay;  ///< throws InputError for a log that cannot be
};

/// Returns the exit code: 1 when anything differs from the baseline, 2 when no log could be replayed.
int replay_season(const Season& season, std::FILE* to);

}  // namespace voltlap::plant
