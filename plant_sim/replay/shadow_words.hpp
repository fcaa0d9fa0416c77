// SPDX-License-Identifier: Apache-2.0
// What a shadow says while it runs: where it stands, and each disagreement when it comes.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "replay/replay_result.hpp"

namespace voltlap::plant {

/// SOC, limits and faults of the firmware at the end of a replay, those of the log's own unit in brackets.
[[nodiscard]] std::string status_text(const ReplayResult& result);

/// Why a log cannot be replayed yet, of the message of an error: what was found.
[[nodiscard]] std::string waiting_text(const std::string& message);

/// Which disagreements of a replay of the growing log were not there in the replay before: of a kind that is new, or
/// decided by another stretch and weightier.
class NewDisagreements {
 public:
  [[nodiscard]] std::vector<Disagreement> of(const ReplayResult& result);

 private:
  struct Said {
    double begin_s = 0.0, weight = 0.0;
  };
  std::map<std::string, Said> said_;
};

}  // namespace voltlap::plant
